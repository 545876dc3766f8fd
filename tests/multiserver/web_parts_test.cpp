// SPDX-License-Identifier: Apache-2.0
// What stands between browsers and sessions, without sockets: hosts, files, lengths and tickets.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>

#include "core/comm/error.h"
#include "multiserver/server/tickets.h"
#include "multiserver/web/gui_files.h"
#include "multiserver/web/hosts.h"
#include "multiserver/web/opening.h"
#include "multiserver/web/whole_message.h"
#include "tests/support/temporary_folder.h"

namespace gxy::test {
namespace {

std::span<const std::byte> partBytes(std::string_view text) { return std::as_bytes(std::span(text)); }

TEST(Hosts, AreThisMachineTheBindAddressAndTheNamesGiven) {
  const Hosts hosts({"Viz.Example.org", "fd00:0::7"}, "192.168.1.5");
  for (const char* host : {"localhost", "LOCALHOST:5001", "127.0.0.1:1", "127.9.8.7", "[::1]", "[0:0::1]:80",
                           "192.168.1.5:5001", "viz.example.org", "VIZ.example.org:443", "[fd00::7]:5001"})
    EXPECT_TRUE(hosts.allows(host)) << host;
  for (const char* host : {"",
                           "evil.test",
                           "evil.test:5001",
                           "localhost.evil.test",
                           "xlocalhost",
                           "localhost:",
                           "localhost:x",
                           "localhost:5001:5001",
                           "localhost:500100",
                           "user@localhost",
                           "localhost/",
                           "127.0.0.1.evil.test",
                           "[::1",
                           "[::1]x",
                           "[localhost]",
                           "::1",
                           "192.168.1.50",
                           "0x7f.1",
                           "2130706433",
                           "localhost, evil.test",
                           " localhost"})
    EXPECT_FALSE(hosts.allows(host)) << host;
}

TEST(Hosts, AnUnspecifiedBindAddressIsNoHost) {
  EXPECT_FALSE(Hosts({}, "0.0.0.0").allows("0.0.0.0:5001"));
  EXPECT_FALSE(Hosts({}, "::").allows("[::]:5001"));
  EXPECT_TRUE(Hosts({}, "::").allows("localhost"));
}

TEST(Hosts, AnOriginIsTheHostItself) {
  const Hosts hosts({"viz.example.org"}, "127.0.0.1");
  EXPECT_TRUE(hosts.allowsOrigin("http://localhost:5001", "localhost:5001"));
  EXPECT_TRUE(hosts.allowsOrigin("http://LocalHost:5001", "localhost:5001"));
  EXPECT_TRUE(hosts.allowsOrigin("https://viz.example.org", "viz.example.org")) << "a proxy with TLS";
  for (const char* origin :
       {"", "null", "localhost:5001", "http://localhost", "http://localhost:5002", "https://localhost:5001",
        "file://localhost:5001", "http://127.0.0.1:5001", "http://localhost:5001/", "http://evil.test:5001"})
    EXPECT_FALSE(hosts.allowsOrigin(origin, "localhost:5001")) << origin;
  EXPECT_FALSE(hosts.allowsOrigin("http://evil.test", "evil.test")) << "equal, but not a name of this server";
}

TEST(Hosts, NamesWithPortsOrPathsAreRefusedAsOptions) {
  EXPECT_EQ(Hosts::wrongName("viz.example.org"), "");
  EXPECT_EQ(Hosts::wrongName("10.0.0.1"), "");
  for (const char* name : {"", "viz:80", "http://viz", "viz/", "v z"})
    EXPECT_NE(Hosts::wrongName(name), "") << name;
}

TEST(Opening, IsKnownFromTheFirstBytes) {
  const auto of = [](std::string_view text) { return openingOf(partBytes(text)); };
  EXPECT_EQ(of("GALA"), Opening::Galaxy);
  EXPECT_EQ(of("GALAXY\r\n"), Opening::Galaxy);
  EXPECT_EQ(of("GET / HTTP/1.1"), Opening::Web);
  EXPECT_EQ(of("HEAD /"), Opening::Web);
  EXPECT_EQ(of("POST /"), Opening::Web) << "which is then answered by 405";
  for (const char* begin : {"", "G", "GA", "GAL", "GET", "HEA"})
    EXPECT_EQ(of(begin), Opening::Unknown) << begin;
  for (const char* other : {"g", "GX", "SSH-2.0", "\x16\x03\x01", "get /"})
    EXPECT_EQ(of(other), Opening::Neither) << other;
}

std::string announced(uint64_t length, size_t payload) {
  std::string bytes(16 + payload, 'x');
  std::memcpy(bytes.data(), &length, sizeof length);
  return bytes;
}

TEST(WholeMessage, HasTheLengthThatItsHeaderTellsHoweverItIsCut) {
  for (size_t piece = 1; piece < 30; piece++) {
    WholeMessage whole;
    for (size_t payload : {size_t(0), size_t(1), size_t(10)}) {
      const std::string text = announced(payload, payload);
      for (size_t at = 0; at < text.size(); at += piece)
        whole.take(partBytes(text).subspan(at, std::min(piece, text.size() - at)), at + piece >= text.size());
    }
  }
}

TEST(WholeMessage, RefusesAnotherLength) {
  const auto take = [](const std::string& text, bool last = true) {
    WholeMessage().take(partBytes(text), last);
  };
  EXPECT_THROW(take(""), Error) << "empty";
  EXPECT_THROW(take(std::string(15, '\0')), Error) << "less than a header";
  EXPECT_THROW(take(announced(5, 4)), Error) << "short";
  EXPECT_THROW(take(announced(5, 6)), Error) << "long";
  EXPECT_THROW(take(announced(5, 6), false), Error) << "long, and goes on";
  EXPECT_THROW(take(announced(uint64_t(0) - 1, 6)), Error);
  EXPECT_THROW(take(announced(uint64_t(0) - 16, 0)), Error) << "16 more would be 0";
}

/// A folder as a build of the GUI leaves it.
struct GuiFolder {
  GuiFolder() {
    std::filesystem::create_directories(folder.path() / "assets");
    write("index.html", "<!doctype html>");
    write("assets/main-1a2b.js", "let x = 1;");
    write("assets/main-1a2b.js.gz", "packed");
    write("assets/lonely.js.gz", "packed");
    write(".hidden", "secret");
    std::filesystem::create_symlink("/etc/passwd", folder.path() / "assets/link.txt");
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder.path() / name, std::ios::binary) << text;
  }
  TemporaryFolder folder;
};

TEST(GuiFiles, AreThoseOfTheFolderAndNoOthers) {
  const GuiFolder gui;
  const GuiFiles files(gui.folder.path().string());
  ASSERT_NE(files.find("/"), nullptr);
  EXPECT_EQ(files.find("/")->content, "<!doctype html>");
  EXPECT_EQ(files.find("/")->type, "text/html; charset=utf-8");
  EXPECT_FALSE(files.find("/")->neverChanges);
  const GuiFile* script = files.find("/assets/main-1a2b.js");
  ASSERT_NE(script, nullptr);
  EXPECT_EQ(script->content, "let x = 1;");
  EXPECT_EQ(script->gzip, "packed");
  EXPECT_EQ(script->type, "text/javascript; charset=utf-8");
  EXPECT_TRUE(script->neverChanges);
  for (const char* path :
       {"", "/assets", "/assets/", "/assets/main-1a2b.js.gz", "/assets/lonely.js", "/.hidden",
        "/assets/link.txt", "/../etc/passwd", "/assets/../index.html", "//", "/assets/%6dain-1a2b.js"})
    EXPECT_EQ(files.find(path), nullptr) << path;
}

TEST(GuiFiles, WithoutTheGuiSayHowToGetIt) {
  const GuiFiles files("");
  ASSERT_NE(files.find("/"), nullptr);
  EXPECT_NE(files.find("/")->content.find("--gui DIR"), std::string::npos);
}

TEST(GuiFiles, AFolderWithoutAPageIsAnError) {
  const TemporaryFolder empty;
  EXPECT_THROW(GuiFiles(empty.path().string()), Error);
}

TEST(Tickets, AreRedeemedOnceAndInTime) {
  Tickets tickets;
  const auto now = Tickets::Clock::now();
  const std::string first = tickets.issue("a token", std::chrono::seconds(60), now);
  const std::string second = tickets.issue("another", std::chrono::seconds(60), now);
  EXPECT_EQ(first.size(), 43u);
  EXPECT_EQ(first.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_"),
            first.npos);
  EXPECT_EQ(tickets.redeem(first, now), "a token");
  EXPECT_EQ(tickets.redeem(first, now), std::nullopt) << "twice";
  EXPECT_EQ(tickets.redeem("", now), std::nullopt);
  EXPECT_EQ(tickets.redeem(second + "A", now), std::nullopt);
  EXPECT_EQ(tickets.redeem(second, now + std::chrono::seconds(60)), std::nullopt) << "late";
}

TEST(Tickets, OfAllThatATokenHasTheOldestGoFirst) {
  Tickets tickets;
  const std::string others = tickets.issue("another", Tickets::kShort),
                    oldest = tickets.issue("a token", Tickets::kShort);
  std::set<std::string> issued;
  for (size_t i = 0; i < Tickets::kMost; i++) issued.insert(tickets.issue("a token", Tickets::kShort));
  EXPECT_EQ(issued.size(), Tickets::kMost) << "no two are equal";
  EXPECT_EQ(tickets.redeem(oldest), std::nullopt);
  for (const std::string& ticket : issued) EXPECT_EQ(tickets.redeem(ticket), "a token");
  EXPECT_EQ(tickets.redeem(others), "another") << "whatever other tokens have";
}

}  // namespace
}  // namespace gxy::test
