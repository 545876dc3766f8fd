// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>
#include <limits>

#include "core/comm/error.h"
#include "tests/bench/rows.h"

namespace gxy::bench::test {
namespace {

std::string errorOf(const std::string& path) {
  try {
    readTable(path);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Table, ReadsBackEveryBitOfWhatWasWritten) {
  const TemporaryFolder folder;
  Row a = row("adaptive", "1/512", 1.0 / 3, 1e-300), b = row("fixed", "1/2", 0.1, 2e-5);
  a.scene = "with, a comma and a \"quote\"";
  a.samples = std::numeric_limits<int64_t>::max();
  a.maxError = std::numeric_limits<double>::infinity();
  b.hits = 17, b.wrongSheet = 3, b.dtMax = 0.25;
  TableWriter writer(folder / "t.csv");
  writer.add(a);
  writer.add(b);
  EXPECT_EQ(readTable(folder / "t.csv"), (std::vector<Row>{a, b}));
}

TEST(Table, RowsAreInTheFileAsSoonAsTheyAreAdded) {
  const TemporaryFolder folder;
  TableWriter writer(folder / "t.csv");
  EXPECT_THROW(readTable(folder / "t.csv"), Error);  // nothing has been measured
  writer.add(row("fixed", "1", 1, 1));
  EXPECT_EQ(readTable(folder / "t.csv").size(), 1u);
}

TEST(Table, SaysWhereAndWhatIsWrong) {
  const TemporaryFolder folder;
  const std::string path = folder / "t.csv";
  TableWriter(path).add(row("fixed", "1", 1, 1));
  std::ifstream in(path);
  std::string header;
  std::getline(in, header);
  std::ofstream(path) << header << "\nscene,fixed,1,embree,one\n";
  EXPECT_EQ(errorOf(path), path + ":2: ranks: expected a number, found 'one'");
  std::ofstream(path) << "a,b\n1,2\n";
  EXPECT_EQ(errorOf(path), path + ":1: there is no column scene; expected a table of gxybench");
  EXPECT_EQ(errorOf(folder / "none"), folder / "none" + ": cannot be read");
}

}  // namespace
}  // namespace gxy::bench::test
