// SPDX-License-Identifier: Apache-2.0
// Delivers pictures from the rank that owns a frame to rank 0, as tiles, sums, depths or encoded files, or writes files.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "core/annotate/overlay.h"
#include "multiserver/protocol/pixel_record.h"
#include "multiserver/server/server_rank.h"

namespace gxy {

/// The form in which the owner of a frame delivers its picture.
struct PictureFormat {
  enum class As : uint8_t { Tiles, Sums, Depth, Bytes, File };
  As as = As::Tiles;
  protocol::PixelEncoding encoding = protocol::PixelEncoding::Zstd;
  int quality = 75;
  uint32_t tile = protocol::kTileSide;  ///< Tiles: the side of each, at most kMostTileSide
  std::string format = "png";           ///< Bytes and File: the format that encodeImage() takes
  std::string path;                     ///< File: a path that DataFolders has checked
  std::string depthPath;  ///< File: where the depths go, as encodeDepth() makes them; empty: nowhere
  Overlay overlay;        ///< Bytes and File: drawn over the picture
};

/// Receives a picture on rank 0. Pieces arrive in any order. `tile` is called on the rank's progress thread and must be short.
/// `sums`, `depth` and `bytes` are called as tasks. `done` is called once, after all of them, as a task; its error is empty
/// if nothing went wrong.
struct PictureReceiver {
  std::function<void(Bytes tile)>
      tile;  ///< a record in which window, frame, scale and pass are to be filled in
  std::function<void(Picture picture)> sums;
  std::function<void(const std::vector<double>& depth)> depth;  ///< of each pixel, as Picture::depth
  std::function<void(Bytes content)> bytes;
  std::function<void(bool superseded, const std::string& error)> done;
};

/// Returns the tiles of a picture, of side x side pixels and smaller at its ends, as records with window 0, frame 0, scale 1 and pass 0. May use all threads.
std::vector<Bytes> tilesOfPicture(const Picture& picture, protocol::PixelEncoding encoding, int quality,
                                  uint32_t side);

/// Starts frames and delivers their pictures. There is one on each rank (Rendering). Thread safe.
class PictureDelivery {
 public:
  explicit PictureDelivery(ServerRank& serverRank);
  ~PictureDelivery();

  /// Rank 0: starts a frame whose picture goes to `receiver`. Throws Error as Renderer::render() does, and calls nothing then.
  FrameId start(FrameRequest request, const PictureFormat& wanted, PictureReceiver receiver);

 private:
  struct Expected {
    PictureReceiver receiver;
    uint64_t pieces = 0, announced = 0;
    bool finished = false, told = false;
    std::string error;
  };
  using ExpectedPtr = std::shared_ptr<Expected>;

  class Operation;
  // `ticket`: the number under which rank 0 keeps the receiver of a picture. Rank 0 chooses it before the
  // frame has a number. It travels with the frame's operation to the frame's owner, and back with each piece.
  void deliver(uint64_t ticket, const PictureFormat& wanted, Picture picture);
  uint64_t sendPieces(uint64_t ticket, const PictureFormat& wanted, Picture picture);
  void receive(Bytes message);
  void receivePiece(uint64_t ticket, Expected& expected, const Bytes& message);
  void onFinished(uint64_t ticket, const Renderer::Ending& ending);
  void conclude(uint64_t ticket, std::unique_lock<std::mutex>& lock);
  ExpectedPtr find(uint64_t ticket) const;

  ServerRank& serverRank_;
  mutable std::mutex mutex_;
  std::map<uint64_t, ExpectedPtr> expected_;  ///< rank 0
  uint64_t nextTicket_ = 1;
};

}  // namespace gxy
