// SPDX-License-Identifier: Apache-2.0
#include "core/scene/paraview_camera.h"

#include "tests/scene/scene_test_support.h"

namespace gxy {
namespace {

constexpr const char* kXml = R"(<?xml version="1.0"?>
<PVCameraConfiguration description="ParaView camera configuration" version="1.0">
  <Proxy group="views" type="RenderView" id="6135" servers="21">
    <Property name="CameraPosition" id="6135.CameraPosition" number_of_elements="3">
      <Element index="0" value="1.5"/>
      <Element index="1" value="-2e1"/>
      <Element index="2" value="3"/>
    </Property>
    <Property name="CameraFocalPoint" id="6135.CameraFocalPoint" number_of_elements="3">
      <Element index="0" value="0"/>
      <Element index="1" value="0"/>
      <Element index="2" value="1"/>
    </Property>
    <Property name="CameraViewUp" id="6135.CameraViewUp" number_of_elements="3">
      <Element index="0" value="0"/>
      <Element index="1" value="0"/>
      <Element index="2" value="1"/>
    </Property>
    <Property name="CameraViewAngle" id="6135.CameraViewAngle" number_of_elements="1">
      <Element index="0" value="25"/>
    </Property>
    <Property name="CameraParallelScale" id="6135.CameraParallelScale" number_of_elements="1">
      <Element index="0" value="3.5"/>
    </Property>
    <Property name="CameraParallelProjection" id="6135.CameraParallelProjection" number_of_elements="1">
      <Element index="0" value="0"/>
      <Domain name="bool" id="6135.CameraParallelProjection.bool"/>
    </Property>
  </Proxy>
</PVCameraConfiguration>
)";

constexpr const char* kJson =
    R"({"PVCameraConfiguration": {"@version": "1.0", "Proxy": {"@group": "views", "Property": [
  {"@name": "CameraPosition", "Element": [{"@index": "0", "@value": "1.5"}, {"@index": "1", "@value": "-2e1"},
                                          {"@index": "2", "@value": "3"}]},
  {"@name": "CameraFocalPoint", "Element": [{"@value": "0"}, {"@value": "0"}, {"@value": "1"}]},
  {"@name": "CameraViewUp", "Element": [{"@value": "0"}, {"@value": "0"}, {"@value": 1}]},
  {"@name": "CameraViewAngle", "Element": {"@index": "0", "@value": "25"}}]}}})";

TEST(ParaViewCamera, XmlAndItsJsonConversionGiveTheSameCamera) {
  const Camera camera = parseParaViewCamera(kXml, "c.pvcc");
  EXPECT_EQ(camera.viewpoint, glm::dvec3(1.5, -20, 3));
  EXPECT_EQ(camera.viewdirection, glm::dvec3(-1.5, 20, -2));
  EXPECT_EQ(camera.viewup, glm::dvec3(0, 0, 1));
  EXPECT_EQ(camera.aov, 25);
  EXPECT_EQ(parseParaViewCamera(kJson, "c.json"), camera);
}

TEST(ParaViewCamera, ParallelProjectionBecomesOrthographicWithTheSameWindow) {
  std::string xml = kXml;
  const size_t at = xml.find("value=\"0\"", xml.find("CameraParallelProjection\" id"));
  xml.replace(at, 9, "value=\"1\"");
  const Camera camera = parseParaViewCamera(xml, "c.pvcc");
  EXPECT_EQ(camera.aov, 0);
  EXPECT_EQ(camera.height, 7);
}

TEST(ParaViewCamera, MissingAndMalformedPartsAreNamed) {
  const auto message = [](std::string text) { return errorOf([&] { parseParaViewCamera(text, "c.pvcc"); }); };
  std::string noUp = kXml;
  noUp.replace(noUp.find("\"CameraViewUp\""), 14, "\"Other\"");
  EXPECT_EQ(message(noUp), "c.pvcc: expected a ParaView camera with three values of CameraViewUp");
  std::string word = kXml;
  word.replace(word.find("1.5"), 3, "one");
  EXPECT_EQ(message(word), "c.pvcc: `CameraPosition`: expected a number, found \"one\"");
  EXPECT_NE(message("hello").find("PVCameraConfiguration"), std::string::npos);
  EXPECT_NE(message("{}").find("no `PVCameraConfiguration`"), std::string::npos);
  EXPECT_NE(message("<PVCameraConfiguration><Property").find("ends inside a tag"), std::string::npos);
}

}  // namespace
}  // namespace gxy
