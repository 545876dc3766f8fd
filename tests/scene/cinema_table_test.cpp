// SPDX-License-Identifier: Apache-2.0
// Tables of Cinema databases, and what is found wrong with broken ones.
#include "core/scene/cinema_table.h"

#include <climits>
#include <cstdint>
#include <fstream>
#include <limits>

#include "core/scene/check_cinema.h"
#include "core/scene/cinema_page.h"
#include "tests/scene/scene_test_support.h"
#include "tests/support/temporary_folder.h"

namespace gxy {
namespace {

TEST(CinemaTable, TypesAreThoseThatReadersSee) {
  for (const char* integer : {"0", "-12", "+3", " 7 ", "1_000"})
    EXPECT_EQ(cellType(integer), TableCellType::Integer) << integer;
  for (const char* number : {"0.0", "-1e5", "1.", "inf", "NaN", "-Infinity"})
    EXPECT_EQ(cellType(number), TableCellType::Float) << number;
  for (const char* text : {"", "a", "0x1p3", "1,5", "1.0 m", "nan(1)", "-", "1__0"})
    EXPECT_EQ(cellType(text), TableCellType::Text) << text;
}

TEST(CinemaTable, FloatsAlwaysHaveAPoint) {
  EXPECT_EQ(floatCell(0), "0.0");
  EXPECT_EQ(floatCell(-30), "-30.0");
  EXPECT_EQ(floatCell(0.1), "0.1");
  EXPECT_EQ(floatCell(1e20), "1.0e+20");
  EXPECT_EQ(floatCell(1e-7), "1.0e-07");
  for (const double x : {1.0 / 3, 1e300, 123456789012345680.0, 5e-324}) {
    EXPECT_EQ(std::strtod(floatCell(x).c_str(), nullptr), x);
    EXPECT_NE(floatCell(x).find('.'), std::string::npos);
  }
}

TEST(CinemaTable, IsReadAsItWasWritten) {
  CinemaTable table({"phi", "map", "FILE", "FILE_depth"});
  table.put({"0.0", "a, \"b\"\r\nc", "x.png", "x.exr"});
  table.put({"1.0", "d", "y.png", "y.exr"});
  EXPECT_EQ(table.text(),
            "phi,map,FILE,FILE_depth\r\n0.0,\"a, \"\"b\"\"\r\nc\",x.png,x.exr\r\n1.0,d,y.png,y.exr\r\n");
  const CinemaTable again = CinemaTable::read(table.text(), "data.csv");
  EXPECT_EQ(again.columns(), table.columns());
  EXPECT_EQ(again.rows(), table.rows());
  EXPECT_EQ(again.parameters(), 2u);
}

TEST(CinemaTable, RowsOfTheSameParametersAreReplaced) {
  CinemaTable table({"phi", "FILE"});
  table.put({"0.0", "a.png"});
  table.put({"1.0", "b.png"});
  table.put({"0.0", "c.png"});
  EXPECT_EQ(table.rows(), (std::vector<CinemaTable::Row>{{"0.0", "c.png"}, {"1.0", "b.png"}}));
  EXPECT_EQ(table.find({"1.0"})->at(1), "b.png");
  EXPECT_EQ(table.find({"2.0"}), nullptr);
  EXPECT_EQ(errorOf([&] {
              table.put({"2", "d.png"});
            }),
            "table: column \"phi\": \"2\" is an integer, expected a number with a point as in the first row");
  EXPECT_EQ(errorOf([&] { table.put({"2.0"}); }), "table: a row of 1 cells, expected 2");
}

TEST(CinemaTable, GoesOnWithTheSameColumnsOnly) {
  const CinemaTable::Row columns{"phi", "FILE"};
  EXPECT_TRUE(continuedTable({}, columns, "data.csv").rows().empty());
  EXPECT_EQ(continuedTable("phi,FILE\r\n0.0,a.png\r\n", columns, "data.csv").rows().size(), 1u);
  EXPECT_EQ(errorOf([&] { continuedTable("theta,FILE\n0.0,a.png\n", columns, "data.csv"); }),
            "data.csv: its columns are theta, FILE, expected phi, FILE as the sweep makes them; give the "
            "database another name, or "
            "remove this one");
  EXPECT_EQ(errorOf([&] { continuedTable("phi,FILE\n0.0\n", columns, "data.csv"); }),
            "data.csv:2: 1 cells, expected 2 as in the first line");
}

TEST(CinemaTable, NamesOfFilesDifferWhereParametersDo) {
  EXPECT_EQ(cinemaFileName({"-30.0", "Cool to Warm"}, {}), "pictures/-30.0_Cool=20to=20Warm");
  EXPECT_EQ(cinemaFileName({"a_b", "c"}, {}), "pictures/a=5Fb_c");
  EXPECT_EQ(cinemaFileName({"../x", "2.5"}, 1), "time=2.5/..=2Fx");
  EXPECT_EQ(cinemaFileName({"2.5"}, 0), "time=2.5/picture");
  EXPECT_NE(cinemaFileName({"a", "b_c"}, {}), cinemaFileName({"a_b", "c"}, {}));
  EXPECT_NE(errorOf([] {
              cinemaFileName(std::vector<std::string>(4, std::string(60, 'a')), {});
            }).find("expected at most 200"),
            std::string::npos);
  const std::string longest = cinemaFileName({std::string(200, 'a')}, {});
  const std::string partial =
      "." + std::to_string(std::numeric_limits<uint64_t>::max()) + ".partial.";  // of DataFolders::NewFile
  EXPECT_LE(partial.size() + longest.size() - longest.find('/') - 1 + std::string("_depth.exr").size(),
            size_t(NAME_MAX));
}

TEST(CinemaTable, RowsThatWouldNotFitAreRefused) {
  CinemaTable table({"phi", "map", "FILE"});
  EXPECT_NO_THROW(table.expectFits({"1", "2"}, "data.csv")) << "there is no row yet";
  table.put({"0.0", "a", "x.png"});
  EXPECT_NO_THROW(table.expectFits({"1.0", "b"}, "data.csv"));
  EXPECT_EQ(
      errorOf([&] {
        table.expectFits({"1.0", "2.0"}, "data.csv");
      }),
      "data.csv: column \"map\": \"2.0\" is a number with a point, expected a text as in the first row");
}

TEST(CinemaTable, ItsMemoryFollowsFromItsCells) {
  EXPECT_EQ(memoryOfTable(""), 0);
  EXPECT_EQ(memoryOfTable("phi,FILE\n0.0,a.png\n"), 4 * 256 + 19 * 8);
  EXPECT_GT(memoryOfTable(std::string(1 << 20, '\n')), int64_t(256) << 20);
}

/// A database that is valid until a test breaks it.
class CinemaCheckTest : public ::testing::Test {
 protected:
  CinemaCheckTest() {
    std::filesystem::create_directories(database_ / "pictures");
    for (const char* name : {"a.png", "b.png"}) picture(name);
    table("phi,map,FILE\n0.0,x,pictures/a.png\n1.0,x,pictures/b.png\n");
  }
  void write(const std::string& name, const std::string& content) const {
    std::ofstream(database_ / name, std::ios::binary) << content;
  }
  void table(const std::string& text) const { write("data.csv", text); }
  void picture(const std::string& name) const {
    write("pictures/" + name, "\x89PNG\r\n\x1a\n ... IEND\xae\x42\x60\x82");
  }
  /// What is wrong, without the folder's name.
  std::vector<std::string> problems() const {
    std::vector<std::string> some = checkCinema(database_).problems;
    for (std::string& p : some) p.replace(0, database_.string().size(), "");
    return some;
  }
  void expectProblem(const std::string& text, const std::string& problem) const {
    table(text);
    EXPECT_EQ(problems(), std::vector<std::string>{problem}) << text;
  }

  const test::TemporaryFolder folder_;
  const std::filesystem::path database_ = folder_.path() / "a.cdb";
};

TEST_F(CinemaCheckTest, AValidDatabaseHasNoProblems) {
  const CinemaCheck check = checkCinema(database_);
  EXPECT_TRUE(check.problems.empty()) << check.problems.front();
  EXPECT_EQ(check.rows, 2u);
  EXPECT_EQ(check.parameters, 2u);
  EXPECT_EQ(check.fileColumns, 1u);
  table("phi,map,FILE\r\n0.0,x,pictures/a.png\r\n1.0,\"x,y\",pictures/b.png");
  EXPECT_EQ(problems(), std::vector<std::string>{}) << "other line ends, quotes, no last line end";
  EXPECT_TRUE(checkCinema(database_ / "").problems.empty());
  table("phi,map,FILE\n0.0,x,pictures/a.png\nnan,NaN,pictures/b.png\n");
  EXPECT_EQ(problems(), std::vector<std::string>{}) << "values that are missing";
}

TEST_F(CinemaCheckTest, EachKindOfBrokenTableIsFound) {
  expectProblem("", "/data.csv: the table is empty, expected a line with the names of the columns");
  expectProblem("\xEF\xBB\xBFphi,FILE\n0.0,pictures/a.png\n",
                "/data.csv:1: there is a byte order mark, expected the name of the first column");
  expectProblem("phi,FILE\n", "/data.csv: there are no rows, expected one at least");
  expectProblem("phi,FILE\n0.0,pictures/a.png,\n", "/data.csv:2: 3 cells, expected 2 as in the first line");
  expectProblem("phi,FILE\n0.0,pictures/a.png\n\n1.0,pictures/b.png\n",
                "/data.csv:3: the line is blank, expected a row");
  expectProblem(
      "phi,FILE\n0.0,pictures/a.png\n1,pictures/b.png\n",
      "/data.csv:3: column \"phi\": \"1\" is an integer, expected a number with a point as in the first row");
  expectProblem(
      "m,FILE\nx,pictures/a.png\ninf,pictures/b.png\n",
      "/data.csv:3: column \"m\": \"inf\" is a number with a point, expected a text as in the first row");
  expectProblem("phi,FILE\n0.0,pictures/a.png\n0.0,pictures/b.png\n",
                "/data.csv:3: its parameters are those of line 2, expected each combination once");
  expectProblem("phi,phi,FILE\n0.0,1.0,pictures/a.png\n",
                "/data.csv:1: column 2, \"phi\": another column has this name, expected each once");
  expectProblem("phi, x,FILE\n0.0,1.0,pictures/a.png\n",
                "/data.csv:1: column 2, \" x\": expected no blanks around the name");
  expectProblem("phi,,FILE\n0.0,1.0,pictures/a.png\n", "/data.csv:1: column 2, \"\": it has no name");
  expectProblem("phi,7,FILE\n0.0,1.0,pictures/a.png\n",
                "/data.csv:1: column 2, \"7\": expected a name that is no number");
  expectProblem("FILE,phi\npictures/a.png,0.0\n",
                "/data.csv:1: column 2, \"phi\": expected the columns of files to be the last");
  expectProblem("phi,file\n0.0,pictures/a.png\n",
                "/data.csv:1: there is no column of files, expected a last column named FILE");
  expectProblem("phi,FILE\n1.0,pictures/b.png\n0.0,\"pictures/a.png\n", "/data.csv:3: a quote is not closed");
  expectProblem("phi,map,FILE\n0.0,\"x\"y,pictures/a.png\n",
                "/data.csv:2: there is something behind a closing quote, expected a comma");
  expectProblem("phi,map,FILE\n0.0,x\"y\",pictures/a.png\n",
                "/data.csv:2: there is a quote in a cell without quotes around it: \"x\"y\"\"");
}

TEST_F(CinemaCheckTest, EachKindOfWrongFileIsFound) {
  const auto with = [](const std::string& file) { return "phi,FILE\n0.0," + file + "\n"; };
  const auto wrong = [](const std::string& file, const std::string& what) {
    return "/data.csv:2: file \"" + file + "\": " + what;
  };
  expectProblem(with(""), "/data.csv:2: there is no name of a file");
  expectProblem(with("pictures/c.png"), wrong("pictures/c.png", "it is missing"));
  expectProblem(with("pictures"), wrong("pictures", "it is not a regular file"));
  for (const std::string outside : {"/etc/passwd", "../a.cdb/pictures/a.png"})
    expectProblem(with(outside), wrong(outside, "expected a path relative to the database, without \"..\""));
  write("empty.png", "");
  write("half.png", "\x89PNG\r\n\x1a\n ...");
  write("text.png", "text");
  write("text.exr", "text");
  write("some.txt", "text");
  expectProblem(with("empty.png"), wrong("empty.png", "it is empty"));
  expectProblem(with("half.png"), wrong("half.png", "its end is missing"));
  expectProblem(with("text.png"), wrong("text.png", "it is no .png"));
  expectProblem(with("text.exr"), wrong("text.exr", "it is no .exr"));
  table(with("some.txt"));
  EXPECT_EQ(problems(), std::vector<std::string>{});
}

TEST_F(CinemaCheckTest, WhatIsNoDatabaseIsSaid) {
  EXPECT_EQ(checkCinema(folder_ / "none.cdb").problems,
            std::vector<std::string>{folder_ / "none.cdb" + ": there is no such folder"});
  EXPECT_EQ(checkCinema(database_ / "data.csv").problems,
            std::vector<std::string>{(database_ / "data.csv").string() +
                                     ": it is no folder, expected a database NAME.cdb"});
  std::filesystem::rename(database_, folder_.path() / "a");
  EXPECT_EQ(checkCinema(folder_.path() / "a").problems,
            std::vector<std::string>{folder_ / "a" + ": expected a name that ends with .cdb"});
  std::filesystem::create_directory(folder_.path() / "b.cdb");
  EXPECT_EQ(checkCinema(folder_.path() / "b.cdb").problems,
            std::vector<std::string>{folder_ / "b.cdb" + ": there is no data.csv that can be read"});
}

TEST_F(CinemaCheckTest, ManyProblemsAreCounted) {
  std::string text = "phi,FILE\n";
  for (int i = 0; i < 150; i++) text += std::to_string(i) + ".0,none" + std::to_string(i) + ".png\n";
  table(text);
  EXPECT_EQ(problems().size(), kMostCinemaProblems + 1);
  EXPECT_EQ(checkCinema(database_).problems.back(), "and 50 more problems");
}

TEST(CinemaPage, HasTheTableAndNoEndOfItsScript) {
  CinemaTable table({"map", "FILE"});
  table.put({"</script><b>", "pictures/a.png"});
  const std::string page = cinemaPage(table, "a<b.cdb");
  EXPECT_EQ(page.find("</script><b>"), std::string::npos);
  EXPECT_NE(page.find("\\u003c/script>"), std::string::npos);
  EXPECT_NE(page.find("pictures/a.png"), std::string::npos);
  for (const char* outside : {"http:", "https:", "src=\"", "<link", "@import", "fetch(", "XMLHttpRequest"})
    EXPECT_EQ(page.find(outside), std::string::npos) << "nothing is loaded: " << outside;
}

}  // namespace
}  // namespace gxy
