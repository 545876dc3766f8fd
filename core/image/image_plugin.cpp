// SPDX-License-Identifier: Apache-2.0
// Reads and writes pictures, and draws text, with OpenImageIO.
#include "core/image/image_plugin.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <mutex>

#include "core/comm/error.h"
#include "core/comm/plugin.h"
#include "core/image/image_rows.h"

namespace gxy {
namespace {

/// Encodes in memory, because OpenImageIO does not notice a full disk when it writes files itself.
std::vector<std::byte> encoded(const char* format, const OIIO::ImageSpec& spec, const void* rows) {
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  const auto out = OIIO::ImageOutput::create(format);
  if (!out) throw Error(OIIO::geterror());
  if (!out->set_ioproxy(&memory) || !out->open("memory", spec) || !out->write_image(spec.format, rows) ||
      !out->close())
    throw Error(out->geterror());
  const auto whole = std::as_bytes(std::span(bytes));
  return {whole.begin(), whole.end()};
}

std::vector<std::byte> encode(const std::string& format, const Image& image) {
  const bool exr = format == "exr";
  OIIO::ImageSpec spec(image.width, image.height, 4, exr ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:UnassociatedAlpha", exr ? 0 : 1);
  if (exr) return encoded("openexr", spec, flipped(image.rgba, image.height).data());
  return encoded("png", spec, flipped(eightBits(image.rgba), image.height).data());
}

std::vector<std::byte> encodeDepth(int width, int height, std::span<const double> depth) {
  OIIO::ImageSpec spec(width, height, 1, OIIO::TypeDesc::FLOAT);
  spec.channelnames = {"Z"};
  spec.z_channel = 0;
  const std::vector<float> values(depth.begin(), depth.end());
  return encoded("openexr", spec, flipped(values, height).data());
}

Image read(const std::string& path) {
  OIIO::ImageSpec request;
  request.attribute("oiio:UnassociatedAlpha", 1);  // values as in the file; PNG is premultiplied below
  const auto in = OIIO::ImageInput::open(path, &request);
  if (!in) throw Error(path + ": cannot read the picture: " + OIIO::geterror());
  const OIIO::ImageSpec& spec = in->spec();
  const int channels = spec.nchannels;
  const size_t pixels = size_t(spec.width) * size_t(spec.height);
  std::vector<float> values(pixels * size_t(channels));
  if (spec.depth > 1 || channels < 1 ||
      !in->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, values.data()))
    throw Error(path + ": cannot read the picture: " + in->geterror());

  LargeVector<float> rgba(pixels * 4);
  const bool colour = channels >= 3, hasAlpha = channels == 2 || channels >= 4;
  const bool premultiplied = std::string(in->format_name()) != "png";
  for (size_t i = 0; i < pixels; ++i) {
    const float* from = &values[i * size_t(channels)];
    const float alpha = hasAlpha ? from[colour ? 3 : 1] : 1.f;
    const float scale = premultiplied ? 1.f : alpha;
    for (size_t c = 0; c < 3; ++c) rgba[4 * i + c] = from[colour ? c : 0] * scale;
    rgba[4 * i + 3] = alpha;
  }
  return {spec.width, spec.height, flipped(rgba, spec.height)};
}

TextMask text(const std::string& text, int pixels) {
  static std::mutex one;  // Several threads must not use OpenImageIO's fonts at once.
  const std::lock_guard lock(one);
  const char* const kFont = "DejaVuSans";
  const OIIO::ROI used = OIIO::ImageBufAlgo::text_size(text, pixels, kFont);
  if (!used.defined())
    throw Error(std::string("drawing text: the font ") + kFont +
                " is not there, install it (Debian: fonts-dejavu-core)");
  const int above = (pixels * 19 + 19) / 20,
            below = (pixels + 3) / 4;  // heights of the font's ascenders and descenders
  TextMask mask{std::max(used.xend, 1), above + below, {}};
  OIIO::ImageBuf buffer(OIIO::ImageSpec(mask.width, mask.height, 1, OIIO::TypeDesc::FLOAT));
  OIIO::ImageBufAlgo::zero(buffer);
  const float white[] = {1};
  if (!OIIO::ImageBufAlgo::render_text(buffer, 0, above, text, pixels, kFont, white))
    throw Error("drawing text: " + buffer.geterror());
  mask.coverage.resize(size_t(mask.width) * size_t(mask.height));
  buffer.get_pixels(buffer.roi(), OIIO::TypeDesc::FLOAT, mask.coverage.data());
  mask.coverage = flipped(mask.coverage, mask.height);
  return mask;
}

const ImagePlugin imageTable = {.encode = encode, .encodeDepth = encodeDepth, .read = read, .text = text};

}  // namespace
}  // namespace gxy

GALAXY_PLUGIN(gxy::imageTable)
