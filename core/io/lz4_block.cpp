// SPDX-License-Identifier: Apache-2.0
#include "core/io/lz4_block.h"

namespace gxy {

namespace {
/// A length in a token with this value is continued by bytes that are added, up to the first that is not 255.
constexpr unsigned kLongLength = 15;
constexpr uint64_t kShortestMatch = 4;
}  // namespace

Lz4Block::Step Lz4Block::decode(std::span<const std::byte> in, std::span<std::byte> out) {
  Step step{0, 0, false};
  for (;;) {
    const bool more = step.used < in.size();
    switch (expects_) {
      case Expects::Token: {
        if (!more) return step;
        const auto token = unsigned(in[step.used++]);
        literals_ = token >> 4;
        matchCode_ = token & 15;
        expects_ = literals_ == kLongLength ? Expects::LiteralLength : Expects::Literals;
        break;
      }
      case Expects::LiteralLength: {
        if (!more) return step;
        const auto length = unsigned(in[step.used++]);
        literals_ += length;
        if (length != 255) expects_ = Expects::Literals;
        break;
      }
      case Expects::Literals:
        for (; literals_ > 0 && step.used < in.size() && step.made < out.size(); --literals_)
          put(in[step.used++], out, step);
        if (literals_ > 0) return step;
        expects_ = Expects::Offset;
        offsetBytes_ = 0;
        offset_ = 0;
        break;
      case Expects::Offset:
        if (!more) return step;
        offset_ |= size_t(in[step.used++]) << 8 * offsetBytes_++;
        if (offsetBytes_ < 2) break;
        if (offset_ == 0 || offset_ > put_) return {step.used, step.made, true};
        match_ = matchCode_ + kShortestMatch;
        expects_ = matchCode_ == kLongLength ? Expects::MatchLength : Expects::Match;
        break;
      case Expects::MatchLength: {
        if (!more) return step;
        const auto length = unsigned(in[step.used++]);
        match_ += length;
        if (length != 255) expects_ = Expects::Match;
        break;
      }
      case Expects::Match:
        for (; match_ > 0 && step.made < out.size(); --match_)
          put(window_[(put_ - offset_) % kWindow], out, step);
        if (match_ > 0) return step;
        expects_ = Expects::Token;
        break;
    }
  }
}

}  // namespace gxy
