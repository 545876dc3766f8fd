// SPDX-License-Identifier: Apache-2.0
// What a request over HTTP is answered with.
#pragma once
#include <utility>  // Asio 1.74 forgets it under C++20

#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>

#include <string>
#include <string_view>

#include "multiserver/web/gui_files.h"
#include "multiserver/web/hosts.h"

namespace gxy {

/// What the server shows to browsers. It does not change, so it is thread safe.
struct Site {
  GuiFiles files;
  Hosts hosts;
};

/// The name of the protocol in a WebSocket, with its version (Sec-WebSocket-Protocol).
inline constexpr const char* kSubprotocol = "galaxy.1";

using WebRequest = boost::beast::http::request<boost::beast::http::empty_body>;

struct Answer {
  std::string head;       ///< status line and fields, with the empty line after them
  std::string text;       ///< the body where it is no file
  std::string_view file;  ///< the body where it is a file: part of the Site
  bool upgrade = false;   ///< the request is one for a WebSocket, and is granted; the rest is empty
  bool close = false;     ///< the connection ends with this answer

  std::string_view body() const { return text.empty() ? file : text; }
};

/// Answers a request that could be read. The result must not outlive the site.
Answer answerTo(const Site& site, const WebRequest& request);

/// Answers what could not be read as a request, or was not allowed as one. The connection then ends.
Answer refusal(int status, const std::string& why);

/// The fields that every answer has, for instance the content security policy; each ends with a line end.
std::string commonFields();

}  // namespace gxy
