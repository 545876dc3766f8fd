// SPDX-License-Identifier: Apache-2.0
#include "gxy/server/data_folders.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "gxy/comm/error.h"
#include "support/temporary_folder.h"

namespace gxy {
namespace {

namespace fs = std::filesystem;

struct Place {
  Place() {
    fs::create_directories(folder / "data/sub");
    fs::create_directories(folder / "data-more");
    for (const char* name : {"data/a.raw", "data/sub/b.raw", "secret.raw", "data-more/c.raw"})
      std::ofstream(folder / name) << "bytes";
    fs::create_symlink(folder / "secret.raw", folder / "data/link.raw");
    fs::create_directory_symlink(folder.path(), folder / "data/up");
    fs::create_symlink(folder / "data/sub/b.raw", folder / "data/inner.raw");
    fs::create_directory(folder / "data/folder.raw");
  }
  test::TemporaryFolder folder;
};

TEST(DataFolders, LetInWhatLiesInside) {
  Place place;
  const DataFolders folders({place.folder / "data", place.folder / "data-more"});
  const std::string a = fs::canonical(place.folder / "data/a.raw");
  for (const std::string& name :
       {std::string("a.raw"), std::string("sub/../a.raw"), a, std::string("./a.raw")})
    EXPECT_EQ(folders.toRead(name), a) << name;
  EXPECT_EQ(folders.toRead("inner.raw"), fs::canonical(place.folder / "data/sub/b.raw"));
  EXPECT_EQ(folders.toRead("c.raw"), fs::canonical(place.folder / "data-more/c.raw"))
      << "of the second folder";
}

TEST(DataFolders, KeepOutWhatLiesOutside) {
  Place place;
  const DataFolders folders({place.folder / "data"});
  for (const std::string& name :
       {std::string("../secret.raw"), place.folder / "secret.raw", std::string("link.raw"),
        std::string("up/secret.raw"), std::string("up/data/../secret.raw"), place.folder / "data-more/c.raw",
        std::string("../data-more/c.raw"), std::string(""), std::string("."), std::string("folder.raw"),
        std::string("nowhere"), std::string("a.raw\0.vol", 10), std::string("/dev/zero"),
        std::string("/proc/self/environ")})
    EXPECT_THROW(folders.toRead(name), Error) << name;
}

TEST(DataFolders, DoNotTellWhetherAFileOutsideExists) {
  Place place;
  const DataFolders folders({place.folder / "data"});
  const auto message = [&](const std::string& name) {
    try {
      folders.toRead(name);
    } catch (const Error& e) {
      std::string text = e.what();
      text.replace(text.find(name), name.size(), "NAME");
      return text;
    }
    return std::string("let in");
  };
  EXPECT_EQ(message("../secret.raw"), message("../absent.raw"));
}

TEST(DataFolders, FilesThatDescriptionsNameLieInsideToo) {
  Place place;
  const DataFolders folders({place.folder / "data"});
  const auto describe = [&](const char* file, const std::string& raw) {
    std::ofstream(place.folder / (std::string("data/") + file)) << "uchar\n0 0 0\n2 2 2\n1 1 1\n"
                                                                << raw << "\n";
  };
  describe("good.vol", "a.raw");
  EXPECT_NO_THROW(folders.dataToRead("good.vol"));
  for (const std::string& raw :
       {std::string("../secret.raw"), place.folder / "secret.raw", std::string("link.raw")}) {
    describe("bad.vol", raw);
    EXPECT_THROW(folders.dataToRead("bad.vol"), Error) << raw;
  }
  std::ofstream(place.folder / "data/bad.part") << R"({"parts": [{"filename": "../secret.vtu"}]})";
  EXPECT_THROW(folders.dataToRead("bad.part"), Error);
  std::ofstream(place.folder / "data/bad.pvtu")
      << R"(<VTKFile type="PUnstructuredGrid"><PUnstructuredGrid><Piece Source="../secret.vtu"/></PUnstructuredGrid></VTKFile>)";
  EXPECT_THROW(folders.dataToRead("bad.pvtu"), Error);
}

TEST(DataFolders, AreWrittenToInsideOnly) {
  Place place;
  const DataFolders folders({place.folder / "data"});
  EXPECT_EQ(folders.toWrite("new.png"), fs::canonical(place.folder / "data") / "new.png");
  EXPECT_EQ(folders.toWrite("sub/new.png"), fs::canonical(place.folder / "data/sub") / "new.png");
  EXPECT_NO_THROW(folders.toWrite("a.raw")) << "may be replaced";
  for (const char* name : {"../new.png", "up/new.png", "nowhere/new.png", "/tmp/new.png", "", "..", "sub/..",
                           "link.raw", "folder.raw", "up"})
    EXPECT_THROW(folders.toWrite(name), Error) << name;
}

TEST(DataFolders, AreLeftByNoLinkThatIsPutInPlaceBeforeAFileIsWritten) {
  Place place;
  const DataFolders folders({place.folder / "data"});
  const std::string text = "new";
  const auto bytes = std::as_bytes(std::span(text));
  const auto content = [&](const std::string& name) {
    std::ifstream in(place.folder / name);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const std::string path = folders.toWrite("sub/new.png");
  folders.write(path, bytes);
  EXPECT_EQ(content("data/sub/new.png"), "new");
  // What was checked has become a link since.
  fs::create_symlink(place.folder / "secret.raw", path + ".partial");
  fs::remove(path);
  fs::create_symlink(place.folder / "secret.raw", path);
  folders.write(path, bytes);
  EXPECT_EQ(content("secret.raw"), "bytes");
  EXPECT_EQ(content("data/sub/new.png"), "new");
  fs::remove_all(place.folder / "data/sub");
  fs::create_directory_symlink(place.folder / "data-more", place.folder / "data/sub");
  EXPECT_THROW(folders.write(path, bytes), Error);
  EXPECT_FALSE(fs::exists(place.folder / "data-more/new.png"));
}

}  // namespace
}  // namespace gxy
