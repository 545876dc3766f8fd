// SPDX-License-Identifier: Apache-2.0
// gpu_report as a user runs it: exit status and last line.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <iostream>
#include <sstream>
#include <string>
#include <thread>

#include "tests/vulkan/test_device.h"
#include "tools/gpu-report/report.h"

namespace gxy::vulkan_test {
namespace {

struct Outcome {
  int status;
  std::string output;
};

Outcome report(const std::string& arguments, const std::string& device = testDevice().device) {
  const std::string command =
      std::string(GPU_REPORT) + " --output /dev/null " + arguments + " --device '" + device + "'";
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return {-1, "popen failed"};
  Outcome outcome{};
  char text[256];
  while (std::fgets(text, sizeof text, pipe)) outcome.output += text;
  const int status = pclose(pipe);
  outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return outcome;
}

TEST(GpuReport, WithoutTimeHasComparedNothingAndFails) {
  const Outcome o = report("--minutes 0");
  EXPECT_EQ(o.status, 1);
  EXPECT_NE(o.output.find("\n0 of 20 scenes compared, 0 do not agree; 0 of 4 benchmarks run, 0 failed"),
            std::string::npos)
      << o.output;
}

TEST(GpuReport, SaysInTheReportWhyItEndedEarly) {
  const Outcome o = report("", "no such thing");
  EXPECT_EQ(o.status, 1);
  EXPECT_NE(o.output.find("\nIt ended here: there is no Vulkan device \"no such thing\""), std::string::npos)
      << o.output;
}

TEST(GpuReport, EndsWhereItsTimeIsOverWhateverTheDeviceDoes) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        std::ostringstream file;
        gpu_report::Report begun(file, std::cerr, 0, 0.05);
        std::this_thread::sleep_for(std::chrono::seconds(60));
      },
      testing::ExitedWithCode(1), "The time is over");
  EXPECT_EXIT(
      {
        std::ostringstream file;
        gpu_report::Report done(file, std::cerr, 0, 0.05);
        done.line("done");
        done.finish();
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
        std::_Exit(0);
      },
      testing::ExitedWithCode(0), "^done\n$");
}

TEST(GpuReport, RefusesWhatIsNoTimeAndNoScale) {
  for (const char* wrong :
       {"--minutes nan", "--minutes -1", "--minutes inf", "--scale nan", "--scale 0", "--what"})
    EXPECT_EQ(report(wrong).status, 2) << wrong;
  EXPECT_EQ(report("--help").status, 0);
}

}  // namespace
}  // namespace gxy::vulkan_test
