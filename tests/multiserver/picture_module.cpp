// SPDX-License-Identifier: Apache-2.0
// A module that renders a picture of a state, with what it has in common with other modules.
#include <future>

#include "multiserver/rendering/rendering.h"

namespace {

using nlohmann::json;

// The scene's number, and the bytes of the picture as a raw file.
json pictureOf(gxy::Rendering& rendering, gxy::Request& request) {
  using namespace gxy;
  const std::string tenant = request.session().tenant();
  const State state = DocumentReader(request).state(request.arguments(), "picture").state;
  ShownSoFar shown;
  const SceneCache::Pinned pinned =
      rendering.scenes.get(tenant, state.visualizations.at(0), state.settings, askerOf(request), shown);
  FrameRequest frame;
  frame.scene = pinned.scene->id;
  frame.camera = state.cameras.at(0);
  frame.priority.stream = rendering.nextStream();
  frame.account = tenant;
  PictureFormat wanted;
  wanted.as = PictureFormat::As::Bytes;
  wanted.format = "raw";
  size_t bytes = 0;
  std::promise<std::string> ended;
  PictureReceiver receiver;
  receiver.bytes = [&](const Bytes& content) { bytes = content.size(); };
  receiver.done = [&](bool, const std::string& error) { ended.set_value(error); };
  rendering.pictures.start(frame, wanted, std::move(receiver));
  if (const std::string error = ended.get_future().get(); !error.empty()) throw Error(error);
  return {{"scene", pinned.scene->id}, {"bytes", bytes}};
}

}  // namespace

GALAXY_MODULE(registration) {
  const auto rendering = gxy::renderingOf(registration);
  registration.verb({"picture", "STATE", "", gxy::Order::InTurn,
                     [rendering](gxy::Request& request) { return pictureOf(*rendering, request); }});
}
