// SPDX-License-Identifier: Apache-2.0
// What comes over a socket, before and after the handshake, in pieces: frames, statements and their arguments, handshakes,
// pixel records and tiles. Whatever the bytes: a result or an Error.
#include <cstdint>
#include <cstdlib>
#include <span>

#include "core/comm/error.h"
#include "multiserver/protocol/handshake.h"
#include "multiserver/protocol/json.h"
#include "multiserver/protocol/statement.h"
#include "multiserver/protocol/tile_codec.h"
#include "multiserver/protocol/wire_message.h"

namespace {

using namespace gxy::protocol;

template <class Parse>
void errorOrNothing(Parse parse) {
  try {
    parse();
  } catch (const gxy::Error&) {
  }
}

void takeStatement(std::string_view text) {
  errorOrNothing([&] {
    const Statement statement = parseStatement(text);
    Arguments arguments(statement.arguments, "verb");
    while (const auto word = arguments.word()) {
      const std::string written = asWord(*word);
      Arguments again(written, "verb");
      if (isUtf8(*word) && again.word() != *word) std::abort();
    }
    if (const auto json = arguments.json()) dump(parseObject(*json, "json"));
  });
  std::string rest;
  size_t bytes = 0;
  for (const std::string& statement : cutStatements(text, rest)) bytes += statement.size();
  if (bytes + rest.size() > text.size()) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const size_t piece = 1 + data[0];
  const auto all = std::as_bytes(std::span(data + 1, size - 1));
  for (const auto& rules : {MessageReader::fromClient(1 << 20), MessageReader::fromServer()})
    errorOrNothing([&] {
      MessageReader reader(rules);
      for (size_t at = 0; at < all.size(); at += piece) {
        std::span<const std::byte> some = all.subspan(at, std::min(piece, all.size() - at));
        while (!some.empty())
          if (const auto frame = reader.take(some)) takeStatement(frame->text());
      }
    });
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  takeStatement(text);
  errorOrNothing([&] { parseHello(text); });
  errorOrNothing([&] { parseWelcome(text); });
  errorOrNothing([&] { decodeTile(pixelHeader(all), pixelData(all)); });
  return 0;
}
