// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/data_folders.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "core/comm/error.h"
#include "core/io/geometry_file.h"
#include "core/io/volume_file.h"
#include "core/io/write_volume.h"
#include "tests/support/swapped_link.h"
#include "tests/support/temporary_folder.h"

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

TEST(DataFolders, GiveTextsOfWhatLiesInsideAndIsNotTooLong) {
  Place place;
  const DataFolders folders({place.folder / "data"});
  EXPECT_EQ(folders.textOf("a.raw", 5), "bytes");
  EXPECT_THROW(folders.textOf("a.raw", 4), Error);
  for (const char* name : {"../secret.raw", "link.raw", "up/secret.raw", "nowhere"})
    EXPECT_THROW(folders.textOf(name, 100), Error) << name;
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

/// A file of a kind that is opened in a way of its own, and which of the files that reading it opens is swapped.
struct Kind {
  std::string name, swapped;
};
const std::vector<Kind> kKinds = {{"raw.vol", "raw.raw"},       {"appended.vti", "appended.vti"},
                                  {"text.vti", "text.vti"},     {"pieces.pvti", "piece.vti"},
                                  {"legacy.vtk", "legacy.vtk"}, {"points.vtp", "points.vtp"},
                                  {"parts.pvtp", "part.vtp"},   {"mesh.obj", "mesh.obj"}};

/// All of them, with this value everywhere.
void writeAll(const std::string& folder, int value) {
  const auto file = [&](const char* name) { return std::ofstream(folder + "/" + name); };
  const std::string one = std::to_string(value), eight = one + " " + one + " " + one + " " + one + " " + one +
                                                         " " + one + " " + one + " " + one;
  const std::vector<std::byte> bytes(8, std::byte(value));
  file("raw.raw").write(reinterpret_cast<const char*>(bytes.data()), 8);
  file("raw.vol") << "uchar\n0 0 0\n2 2 2\n1 1 1\nraw.raw\n";
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  VolumeWriter(folder + "/appended.vti", grid, {{"v", ScalarType::UInt8, 1, {}}}).write(0, 0, bytes);
  for (const char* name : {"text.vti", "piece.vti"})
    file(name)
        << R"(<VTKFile type="ImageData"><ImageData WholeExtent="0 1 0 1 0 1"><Piece Extent="0 1 0 1 0 1">)"
        << R"(<PointData><DataArray type="UInt8" Name="v" format="ascii">)" << eight
        << "</DataArray></PointData></Piece></ImageData></VTKFile>";
  file("pieces.pvti")
      << R"(<VTKFile type="PImageData"><PImageData WholeExtent="0 1 0 1 0 1"><PPointData>)"
      << R"(<PDataArray type="UInt8" Name="v"/></PPointData><Piece Extent="0 1 0 1 0 1" Source="piece.vti"/>)"
      << "</PImageData></VTKFile>";
  file("legacy.vtk") << "# vtk DataFile Version 3.0\nv\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\n"
                     << "ORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA 8\nSCALARS v unsigned_char 1\n"
                     << "LOOKUP_TABLE default\n"
                     << eight << "\n";
  for (const char* name : {"points.vtp", "part.vtp"})
    file(name)
        << R"(<VTKFile type="PolyData"><PolyData><Piece NumberOfPoints="1"><Points><DataArray type="Float32")"
        << R"( NumberOfComponents="3" format="ascii">)" << one << " 0 0"
        << "</DataArray></Points></Piece></PolyData></VTKFile>";
  file("parts.pvtp")
      << R"(<VTKFile type="PPolyData"><PPolyData><Piece Source="part.vtp"/></PPolyData></VTKFile>)";
  file("mesh.obj") << "v " << one << " 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n";
}

int valueIn(const std::string& path) {
  if (!isVolumeFile(path))
    return int(readGeometry(geometryPieces(path).at(0), GeometryKind::Particles, "").block.points.at(0).x);
  const VolumeFile file = openVolume(path, "");
  std::vector<std::byte> samples(8);
  readVolume(file, wholeOf(file.grid), samples);
  EXPECT_EQ(samples, std::vector<std::byte>(8, samples[0]));
  return int(samples[0]);
}

TEST(DataFolders, AreLeftByNoReaderWhoseFileHasBecomeALink) {
  Place place;
  writeAll(place.folder / "data", 1);
  writeAll(place.folder.path(), 2);
  const DataFolders folders({place.folder / "data"});
  for (const Kind& kind : kKinds) {
    const std::string path = folders.dataToRead(kind.name);
    const std::string swapped = place.folder / "data/" + kind.swapped;
    {
      const ReadScope inside = folders.reading();
      EXPECT_EQ(valueIn(path), 1) << kind.name;
      fs::remove(swapped);
      fs::create_symlink(place.folder / kind.swapped, swapped);
      EXPECT_THROW(valueIn(path), Error) << kind.name;
      fs::remove(swapped);
      ASSERT_EQ(mkfifo(swapped.c_str(), 0600), 0);
      EXPECT_THROW(valueIn(path), Error) << kind.name << ": nobody writes to the pipe";
    }
    fs::remove(swapped);
    fs::create_symlink(place.folder / kind.swapped, swapped);
    EXPECT_EQ(valueIn(path), 2) << kind.name << ": for programs that ask for no scope";
  }
}

TEST(DataFolders, AreNotLeftWhileLinksAreSwapped) {
  Place place;
  writeAll(place.folder / "data", 1);
  writeAll(place.folder.path(), 2);
  const DataFolders folders({place.folder / "data"});
  for (const Kind& kind : kKinds) {
    const auto read = [&] {
      const ReadScope inside = folders.reading();
      return valueIn(folders.dataToRead(kind.name));
    };
    {
      const test::SwappedLink swapped(place.folder / "data/" + kind.swapped, place.folder / kind.swapped);
      for (int i = 0; i < 300; i++) try {
          ASSERT_EQ(read(), 1) << kind.name;
        } catch (const Error&) {
          // it was a link just then
        }
    }
    EXPECT_EQ(read(), 1) << kind.name;
  }
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

TEST(DataFolders, KeepNothingOfAFileThatCannotTakeItsName) {
  Place place;
  const DataFolders folders({place.folder / "data"});
  const std::string text = "new";
  const std::string path = folders.toWrite("sub/new.png");
  fs::create_directory(path);  // since it was checked
  EXPECT_THROW(folders.write(path, std::as_bytes(std::span(text))), Error);
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(place.folder / "data/sub"))
    names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"b.raw", "new.png"}));
}

TEST(DataFolders, MakeFoldersInside) {
  Place place;
  const DataFolders folders({place.folder / "data", place.folder / "data-more"});
  const std::string made = folders.makeFolder("sub/a.cdb");
  EXPECT_EQ(made, fs::canonical(place.folder / "data/sub/a.cdb"));
  EXPECT_EQ(folders.makeFolder(made), made) << "it is there";
  EXPECT_EQ(folders.makeFolder(made + "/b"), made + "/b");
  for (const std::string& name :
       {std::string("../out"), std::string("up/out"), std::string(""), std::string("."), std::string(".."),
        std::string("sub/.."), std::string("nowhere/out"), std::string("a.raw"), std::string("link.raw"),
        std::string("up"), place.folder / "out", std::string("a\0b", 3)})
    EXPECT_THROW(folders.makeFolder(name), Error) << name;
  EXPECT_FALSE(fs::exists(place.folder / "out"));
}

}  // namespace
}  // namespace gxy
