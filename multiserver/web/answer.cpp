// SPDX-License-Identifier: Apache-2.0
#include "multiserver/web/answer.h"

#include <boost/beast/http/rfc7230.hpp>
#include <boost/beast/http/status.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include <algorithm>
#include <charconv>

namespace gxy {

namespace beast = boost::beast;
namespace http = beast::http;
using http::field;

namespace {

std::string_view viewOf(beast::string_view text) { return {text.data(), text.size()}; }

/// The fields of an answer, one after the other.
class Fields {
 public:
  void add(const std::string& name, const std::string& value) { text_ += name + ": " + value + "\r\n"; }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::string headOf(int status, const Fields& fields, bool close) {
  std::string head = "HTTP/1.1 " + std::to_string(status) + " " +
                     std::string(viewOf(http::obsolete_reason(http::int_to_status(unsigned(status))))) +
                     "\r\n";
  head += commonFields() + fields.text();
  if (close) head += "Connection: close\r\n";
  return head + "\r\n";
}

// An answer for people, which tells nothing about the server but what to do.
Answer plain(int status, const std::string& why, const WebRequest* request, const std::string& extra = {}) {
  Answer answer;
  answer.close = !request || !request->keep_alive();
  answer.text = why + "\n";
  Fields fields;
  fields.add("Content-Type", "text/plain; charset=utf-8");
  fields.add("Content-Length", std::to_string(answer.text.size()));
  fields.add("Cache-Control", "no-store");
  answer.head = headOf(status, fields, answer.close);
  answer.head.insert(answer.head.size() - 2, extra);
  if (request && request->method() == http::verb::head) answer.text.clear();
  return answer;
}

// Whether one of a list of content codings is gzip, or any, and its weight is not 0.
bool takesGzip(const WebRequest& request) {
  bool named = false, any = false;
  const beast::string_view list = request[field::accept_encoding];
  for (const auto& coding : http::ext_list(list)) {
    bool wanted = true;
    for (const auto& parameter : coding.second)
      if (beast::iequals(parameter.first, "q"))
        wanted = viewOf(parameter.second).find_first_of("123456789") != std::string_view::npos;
    if (beast::iequals(coding.first, "gzip")) {
      if (!wanted) return false;
      named = true;
    }
    any = any || (coding.first == "*" && wanted);
  }
  return named || any;
}

bool knows(const WebRequest& request, const std::string& tag) {
  std::string_view list = viewOf(request[field::if_none_match]);
  return list == "*" || list.find(tag) != std::string_view::npos;
}

Answer fileAnswer(const GuiFile& file, const WebRequest& request) {
  const bool packed = !file.gzip.empty() && takesGzip(request);
  const std::string tag = "\"" + file.tag + (packed ? "-gzip\"" : "\"");
  Answer answer;
  answer.close = !request.keep_alive();
  answer.file = packed ? file.gzip : file.content;
  Fields fields;
  fields.add("ETag", tag);
  fields.add("Cache-Control", file.neverChanges ? "public, max-age=31536000, immutable" : "no-store");
  if (!file.gzip.empty()) fields.add("Vary", "Accept-Encoding");
  if (knows(request, tag)) {
    answer.file = {};
    answer.head = headOf(304, fields, answer.close);
    return answer;
  }
  fields.add("Content-Type", file.type);
  if (packed) fields.add("Content-Encoding", "gzip");
  fields.add("Content-Length", std::to_string(answer.file.size()));
  answer.head = headOf(200, fields, answer.close);
  if (request.method() == http::verb::head) answer.file = {};
  return answer;
}

Answer upgradeAnswer(const Site& site, const WebRequest& request, std::string_view host) {
  if (!beast::websocket::is_upgrade(request))
    return plain(426, "Here is a WebSocket, expected a request to upgrade to it.", &request,
                 "Upgrade: websocket\r\nConnection: Upgrade\r\n");
  if (request[field::sec_websocket_version] != "13")
    return plain(426, "Another version of WebSocket, expected 13.", &request,
                 "Sec-WebSocket-Version: 13\r\n");
  const auto origins = request.equal_range(field::origin);
  if (std::distance(origins.first, origins.second) != 1 ||
      !site.hosts.allowsOrigin(viewOf(origins.first->value()), host))
    return plain(403,
                 "A page of another origin may not open a WebSocket here, expected the server's own page.",
                 &request);
  const http::token_list protocols(request[field::sec_websocket_protocol]);
  if (std::none_of(protocols.begin(), protocols.end(), [](const auto& p) { return p == kSubprotocol; }))
    return plain(400, std::string("WebSocket of another protocol, expected ") + kSubprotocol + ".", &request);
  if (request.count(field::sec_websocket_key) != 1)
    return plain(400, "Expected one field Sec-WebSocket-Key.", &request);
  Answer answer;
  answer.upgrade = true;
  return answer;
}

}  // namespace

std::string commonFields() {
  return "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; worker-src "
         "'self'; "
         "connect-src 'self'; img-src 'self' blob: data:; font-src 'self'; base-uri 'none'; form-action "
         "'none'; "
         "frame-ancestors 'none'\r\n"
         "X-Content-Type-Options: nosniff\r\n"
         "Referrer-Policy: no-referrer\r\n"
         "Cross-Origin-Opener-Policy: same-origin\r\n"
         "Cross-Origin-Resource-Policy: same-origin\r\n";
}

Answer refusal(int status, const std::string& why) { return plain(status, why, nullptr); }

Answer answerTo(const Site& site, const WebRequest& request) {
  const auto hosts = request.equal_range(field::host);
  if (std::distance(hosts.first, hosts.second) != 1) return refusal(400, "Expected one field Host.");
  const std::string_view host = viewOf(hosts.first->value());
  if (!site.hosts.allows(host))
    return plain(
        421, "This server does not answer for this host. If it should, start it with: gxyserver --host NAME",
        &request);
  if (request.method() != http::verb::get && request.method() != http::verb::head)
    return plain(405, "Expected GET or HEAD.", &request, "Allow: GET, HEAD\r\n");
  std::string_view path = viewOf(request.target());
  path = path.substr(0, path.find('?'));
  if (path == "/ws") return upgradeAnswer(site, request, host);
  if (const GuiFile* file = site.files.find(path)) return fileAnswer(*file, request);
  return plain(404, "There is nothing here.", &request);
}

}  // namespace gxy
