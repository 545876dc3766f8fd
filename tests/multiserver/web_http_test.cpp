// SPDX-License-Identifier: Apache-2.0
// What browsers, and those who pretend to be one, get over HTTP.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "tests/multiserver/test_server.h"
#include "tests/multiserver/web_client.h"

namespace gxy::test {
namespace {

/// A server with a GUI of two files.
struct Web {
  explicit Web(ServerSetup setup = {}) {
    std::filesystem::create_directories(gui.path() / "assets");
    write("index.html", "<!doctype html><title>Galaxy</title>");
    write("assets/main-1a2b.js", script);
    write("assets/main-1a2b.js.gz", "packed");
    setup.ranks = 1;
    setup.server.guiFolder = gui.path().string();
    server = std::make_unique<TestServer>(std::move(setup));
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(gui.path() / name, std::ios::binary) << text;
  }
  WebClient::Response ask(const std::string& request, bool bodiless = false) const {
    return WebClient(server->port()).ask(request, bodiless);
  }

  const std::string script = "let x = " + std::string(200000, '1') + ";";
  TemporaryFolder gui;
  std::unique_ptr<TestServer> server;
};

TEST(WebFiles, AreServedWithTheFieldsThatProtectThePage) {
  const Web web;
  const auto page = web.ask(webRequest("/"));
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, "<!doctype html><title>Galaxy</title>");
  for (const char* field :
       {"Content-Type: text/html; charset=utf-8", "Cache-Control: no-store",
        "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; worker-src "
        "'self'; "
        "connect-src 'self'; img-src 'self' blob: data:; font-src 'self'; base-uri 'none'; form-action "
        "'none'; "
        "frame-ancestors 'none'",
        "X-Content-Type-Options: nosniff", "Referrer-Policy: no-referrer",
        "Cross-Origin-Opener-Policy: same-origin", "Cross-Origin-Resource-Policy: same-origin"})
    EXPECT_TRUE(page.has(field)) << field << " in " << page.head;
  EXPECT_EQ(page.head.find("Server:"), std::string::npos);
  const auto script = web.ask(webRequest("/assets/main-1a2b.js?x=1"));
  EXPECT_EQ(script.status, 200);
  EXPECT_EQ(script.body, web.script);
  EXPECT_TRUE(script.has("Cache-Control: public, max-age=31536000, immutable"));
  EXPECT_TRUE(script.has("Vary: Accept-Encoding"));
}

TEST(WebFiles, ComePackedToThoseWhoTakeThat) {
  const Web web;
  const auto with = [&](const std::string& codings) {
    return web.ask(webRequest("/assets/main-1a2b.js", "Accept-Encoding: " + codings + "\r\n"));
  };
  for (const char* codings : {"gzip", "deflate, gzip;q=0.5, br", "*", "GZIP"}) {
    const auto packed = with(codings);
    EXPECT_EQ(packed.body, "packed") << codings;
    EXPECT_TRUE(packed.has("Content-Encoding: gzip")) << codings;
  }
  for (const char* codings : {"br", "gzip;q=0", "gzip;q=0.000, *", "identity", ""})
    EXPECT_EQ(with(codings).body, web.script) << codings;
}

TEST(WebFiles, AreNotSentAgainToThoseWhoHaveThem) {
  const Web web;
  const auto first = web.ask(webRequest("/assets/main-1a2b.js"));
  const size_t at = first.head.find("ETag: ");
  const std::string tag = first.head.substr(at + 6, first.head.find("\r\n", at) - at - 6);
  EXPECT_EQ(web.ask(webRequest("/assets/main-1a2b.js", "If-None-Match: " + tag + "\r\n"), true).status, 304);
  EXPECT_EQ(web.ask(webRequest("/assets/main-1a2b.js", "If-None-Match: \"other\"\r\n")).status, 200);
}

TEST(WebFiles, HeadHasNoBodyAndTheConnectionGoesOn) {
  const Web web;
  WebClient client(web.server->port());
  const auto head = client.ask(webRequest("/", "", "HEAD"), true);
  EXPECT_EQ(head.status, 200);
  EXPECT_TRUE(head.has("Content-Length: 36"));
  EXPECT_EQ(client.ask(webRequest("/")).body.size(), 36u);
}

TEST(WebFiles, OtherPathsAndMethodsAreRefused) {
  const Web web;
  for (const char* path : {"/nothing", "/../etc/passwd", "/assets/..%2f..%2fetc/passwd", "/assets/", "//",
                           "http://localhost:5001/", "*"})
    EXPECT_EQ(web.ask(webRequest(path)).status, 404) << path;
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS", "PATCH", "TRACE"}) {
    const auto refused = web.ask(webRequest("/", "", method));
    EXPECT_EQ(refused.status, 405) << method;
    EXPECT_TRUE(refused.has("Allow: GET, HEAD"));
  }
  EXPECT_EQ(web.ask(webRequest("/ws")).status, 426) << "no upgrade is asked for";
}

TEST(WebFiles, WithoutAGuiThePageSaysHowToGetIt) {
  const TestServer server(ServerSetup{});
  const auto page = WebClient(server.port()).ask(webRequest("/"));
  EXPECT_EQ(page.status, 200);
  EXPECT_NE(page.body.find("gxyserver --gui DIR"), std::string::npos);
}

TEST(WebFiles, ABrowserIsHungUpOnWhereNoneIsWanted) {
  ServerSetup setup;
  setup.server.gui = false;
  const TestServer server(std::move(setup));
  WebClient client(server.port());
  EXPECT_EQ(client.ask(webRequest("/")).status, 0);
}

TEST(WebHosts, AnotherHostIsToldNothingButTheFlag) {
  ServerSetup setup;
  setup.server.hosts = {"viz.example.org"};
  const Web web(std::move(setup));
  const auto of = [&](const std::string& host) { return web.ask(webRequest("/", "", "GET", host)); };
  for (const char* host : {"evil.test", "evil.test:5001", "0.0.0.0:5001", "localhost.evil.test"}) {
    const auto refused = of(host);
    EXPECT_EQ(refused.status, 421) << host;
    EXPECT_NE(refused.body.find("--host NAME"), std::string::npos);
    EXPECT_EQ((refused.head + refused.body).find("evil"), std::string::npos);
  }
  for (const char* host : {"localhost", "localhost:8080", "127.0.0.1:5001", "[::1]:9", "viz.example.org"})
    EXPECT_EQ(of(host).status, 200) << host;
  EXPECT_EQ(web.ask("GET / HTTP/1.1\r\n\r\n").status, 400) << "no Host";
  EXPECT_EQ(web.ask(webRequest("/", "Host: localhost\r\n")).status, 400) << "two of them";
  const auto upgrade = web.ask(webRequest("/ws", upgradeFields("http://evil.test"), "GET", "evil.test"));
  EXPECT_EQ(upgrade.status, 421) << "an origin that equals a wrong host";
}

TEST(WebHosts, OnlyTheServersOwnPageMayUpgrade) {
  const Web web;
  const auto from = [&](const std::string& origin) {
    return web.ask(webRequest("/ws", upgradeFields(origin)), true);
  };
  for (const char* origin :
       {"", "null", "http://localhost:5002", "https://localhost:5001", "http://localhost", "file://",
        "http://evil.test:5001", "chrome-extension://localhost:5001"})
    EXPECT_EQ(from(origin).status, 403) << "'" << origin << "'";
  EXPECT_EQ(web.ask(webRequest("/ws", upgradeFields() + "Origin: http://evil.test\r\n")).status, 403)
      << "two of them";
  const auto granted = from("http://localhost:5001");
  EXPECT_EQ(granted.status, 101);
  EXPECT_TRUE(granted.has("Sec-WebSocket-Protocol: galaxy.1"));
  EXPECT_EQ(granted.head.find("Sec-WebSocket-Extensions"), std::string::npos);
}

TEST(WebHosts, UpgradesOfAnotherFormAreRefused) {
  const Web web;
  const auto with = [&](const std::string& what, const std::string& instead) {
    std::string fields = upgradeFields();
    fields.replace(fields.find(what), what.size(), instead);
    return web.ask(webRequest("/ws", fields)).status;
  };
  EXPECT_EQ(with("Version: 13", "Version: 8"), 426);
  EXPECT_EQ(with("galaxy.1", "galaxy.2"), 400);
  EXPECT_EQ(with("Sec-WebSocket-Protocol: galaxy.1\r\n", ""), 400);
  EXPECT_EQ(with("Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n", ""), 400);
  EXPECT_EQ(with("Upgrade: websocket", "Upgrade: h2c"), 426);
  EXPECT_EQ(web.ask(webRequest("/ws", upgradeFields(), "POST")).status, 405);
  EXPECT_EQ(web.ask(webRequest("/", upgradeFields()), true).status, 200)
      << "an upgrade elsewhere is a request";
  WebClient early(web.server->port());
  EXPECT_EQ(early.ask(webRequest("/ws", upgradeFields()) + "bytes").status, 400) << "before the answer";
}

TEST(WebLimits, HeadersOfNineKilobytesAndBodiesEndTheConnection) {
  const Web web;
  const std::string nine = "X: " + std::string(9 << 10, 'x') + "\r\n";
  EXPECT_EQ(web.ask(webRequest("/", nine)).status, 431);
  std::string many;
  for (int i = 0; i < 900; i++) many += "X: y" + std::to_string(1000 + i) + "\r\n";
  EXPECT_EQ(web.ask(webRequest("/", many)).status, 431);
  EXPECT_EQ(web.ask(webRequest("/" + std::string(9 << 10, 'x'))).status, 431);
  EXPECT_EQ(web.ask(webRequest("/", "X: " + std::string(7 << 10, 'x') + "\r\n")).status, 200)
      << "less is allowed";
  for (const char* body :
       {"Content-Length: 5\r\n", "Content-Length: 99999999999\r\n", "Transfer-Encoding: chunked\r\n"}) {
    WebClient client(web.server->port());
    EXPECT_EQ(client.ask(webRequest("/", body) + "hello").status, 413) << body;
    EXPECT_TRUE(client.closedByServer());
  }
  WebClient strange(web.server->port());
  EXPECT_EQ(strange.ask("GET / HTTP/1.1\r\nno colon here\r\n\r\n").status, 400);
  EXPECT_TRUE(strange.closedByServer());
}

TEST(WebLimits, PipelinedRequestsAreAnsweredInTheirOrder) {
  const Web web;
  WebClient client(web.server->port());
  std::string all;
  for (int i = 0; i < 50; i++)
    all += webRequest("/") + webRequest("/assets/main-1a2b.js") + webRequest("/nothing");
  std::thread sender([&] { client.raw().send(bytesIn(all), 60000); });
  for (int i = 0; i < 50; i++) {
    EXPECT_EQ(client.response().body.size(), 36u);
    EXPECT_EQ(client.response().body, web.script);
    EXPECT_EQ(client.response().status, 404);
  }
  sender.join();
}

TEST(WebLimits, RequestsMayComeByteForByteButNotForever) {
  ServerSetup setup;
  setup.server.connection.patience.handshake = std::chrono::milliseconds(2000);
  const Web web(std::move(setup));
  WebClient slow(web.server->port());
  for (const char c : webRequest("/")) slow.send({&c, 1});
  EXPECT_EQ(slow.response().status, 200);
  EXPECT_TRUE(slow.closedByServer()) << "it asks for nothing more";
  WebClient endless(web.server->port());
  endless.send("GET / HTTP/1.1\r\nHost: localhost\r\n");
  std::atomic<bool> over = false;
  std::thread drip([&] {
    while (!over && endless.send("X: y\r\n")) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  });
  EXPECT_TRUE(endless.closedByServer()) << "a field now and then";
  over = true;
  drip.join();
}

TEST(WebLimits, SilentBrowsersAreClosedForThoseWhoSpeak) {
  ServerSetup setup;
  setup.server.connection.patience.handshake = std::chrono::minutes(10);
  const Web web(std::move(setup));
  std::vector<std::unique_ptr<WebClient>> silent;
  for (int i = 0; i < 300; i++) {
    silent.push_back(std::make_unique<WebClient>(web.server->port()));
    silent.back()->send("GET / HTTP/1.1\r\n");
  }
  EXPECT_EQ(web.ask(webRequest("/")).status, 200);
  EXPECT_NO_THROW(web.server->client()->expect("echo x"));
  EXPECT_TRUE(silent.front()->closedByServer()) << "the oldest";
}

}  // namespace
}  // namespace gxy::test
