// SPDX-License-Identifier: Apache-2.0
#include "core/scene/picture_name.h"

#include <gtest/gtest.h>

namespace gxy {
namespace {

TEST(PictureName, HasTheNumberAndWhatIsShownFromWhere) {
  State state;
  state.visualizations.resize(2);
  state.cameras.resize(2);
  EXPECT_EQ(pictureName("image", state, 0), "image_00000");
  state.visualizations[0].annotation = "volume";
  state.visualizations[1].annotation = "-slice";  // with a separator of its own
  state.cameras[1].annotation = "front";
  EXPECT_EQ(pictureName("out/a", state, 0), "out/a_00000_volume");
  EXPECT_EQ(pictureName("image", state, 1), "image_00001-slice");
  EXPECT_EQ(pictureName("image", state, 2), "image_00002_volume_front");
  EXPECT_EQ(pictureName("image", state, 3), "image_00003-slice_front");
}

}  // namespace
}  // namespace gxy
