// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyrender/pictures.h"

#include "core/annotate/annotations.h"
#include "core/image/image.h"
#include "core/image/replace_file.h"
#include "core/scene/state_pictures.h"

namespace gxy {

std::string pictureName(const State& state, const RenderOptions& options, size_t index) {
  const StatePicture picture = picturesOf(state).at(index);
  return pictureName(options.prefix, options.firstPicture + index,
                     state.visualizations[picture.visualization], picture.camera);
}

void annotate(Picture& picture, const State& state, const LoadedState& loaded, const RenderOptions& options,
              size_t index) {
  if (state.annotations == Annotations()) return;
  const std::vector<StatePicture> pictures = picturesOf(state);
  const size_t visualization = pictures.at(index).visualization;
  const Camera seenFrom = loaded.camera(pictures[index]);
  const size_t step = options.firstPicture / pictures.size();
  Image image{picture.width, picture.height, std::move(picture.rgba)};
  draw(overlayOf(state.annotations, {state.visualizations[visualization], loaded.shown[visualization],
                                     seenFrom, state.settings, step, options.time}),
       image);
  picture.rgba = std::move(image.rgba);
}

void writePicture(const std::string& name, const RenderOptions& options, Picture picture) {
  if (!picture.depth.empty()) replaceFile(name + ".depth", std::as_bytes(std::span(picture.depth)));
  writeImage(name + "." + options.format, Image{picture.width, picture.height, std::move(picture.rgba)});
}

}  // namespace gxy
