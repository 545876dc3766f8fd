// SPDX-License-Identifier: Apache-2.0
#include "tools/msdata/report.h"

#include <filesystem>

#include "core/comm/error.h"
#include "core/image/replace_file.h"
#include "multiserver/protocol/json.h"

namespace gxy {

using nlohmann::json;

namespace {

std::string jsonLine(const json& value) { return protocol::printableJson(protocol::dump(value)); }

std::string indented(const std::string& text) {
  std::string out = "  ";
  for (const char c : text) {
    out += c;
    if (c == '\n') out += "  ";
  }
  return out;
}

// Returns a member of any type as text for users; empty if there is none.
std::string member(const json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end()) return {};
  return found->is_string() ? found->get<std::string>() : protocol::dump(*found);
}

// Returns the name for a picture's file in the current folder, whatever path the server sends.
std::string pictureName(const json& header) {
  const std::string name = member(header, "name");
  const std::string own = std::filesystem::path(name).filename().string();
  if (own.empty() || own == "." || own == ".." || own.find('\0') != std::string::npos)
    throw Error("a picture has come under the name \"" + name + "\", expected that of a file");
  return own;
}

}  // namespace

std::string eventText(const json& event) {
  const std::string kind = member(event, "event");
  if (event.contains("to"))
    return "event: " + kind + " " + member(event, "name") + " to " + member(event, "to") + ", " +
           member(event, "scope");
  if (event.contains("generation"))
    return "event: " + kind + " " + member(event, "name") + ", " + member(event, "scope") + " " +
           member(event, "type") + ", generation " + member(event, "generation");
  json others = event;
  others.erase("event");
  return "event: " + kind + " " + protocol::dump(others);
}

void Report::listenTo(Client::Options& options) {
  options.onEvent = [this](const json& e) { event(e); };
  options.onFile = [this](uint32_t, const json& header, std::span<const std::byte> content) {
    if (header.contains("name"))
      picture(header, content);
    else
      array(header, content);
  };
  options.onEnd = [this](const std::string& reason) { ended_.set_value(reason); };
}

void Report::reply(const std::string& statement, const Reply& reply) {
  if (!reply.ok) failed_ = true;
  if (json_) {
    json line{{"statement", statement}, {"ok", reply.ok}};
    if (reply.ok)
      line["reply"] = reply.value;
    else
      line["error"] = reply.error;
    output_.line(jsonLine(line));
  } else if (!reply.ok) {
    output_.error("error: " + reply.error);
  } else if (const auto text = reply.value.find("text"); text != reply.value.end() && text->is_string()) {
    if (!text->get_ref<const std::string&>().empty()) output_.line(indented(text->get<std::string>()));
  } else if (!reply.value.is_null() && !reply.value.empty()) {
    output_.line(indented(reply.value.dump(2, ' ', false, json::error_handler_t::replace)));
  }
}

void Report::event(const json& event) {
  if (json_)
    output_.line(jsonLine(event));
  else if (member(event, "event") == "progress")
    output_.progress("  " + member(event, "text") + ": " + member(event, "done") + " of " +
                     member(event, "of"));
  else if (member(event, "event") == "waiting")
    output_.error("waiting: " + member(event, "text"));
  else
    output_.line(eventText(event));
}

void Report::array(const json& header, std::span<const std::byte> content) {
  if (json_) {
    json line = header;
    line["bytes"] = content.size();
    output_.line(jsonLine(line));
  } else {
    output_.line("  " + member(header, header.contains("field") ? "field" : "structure") + ": from " +
                 member(header, "first") + " on " + member(header, "count") + " of " + member(header, "of") +
                 ", " + member(header, "components") + " " + member(header, "type") + " each");
  }
}

void Report::picture(const json& header, std::span<const std::byte> content) {
  try {
    const std::string name = pictureName(header);
    replaceFile(name, content);
    if (json_)
      output_.line(jsonLine({{"file", name}, {"bytes", content.size()}}));
    else
      output_.line("  wrote " + name);
  } catch (const Error& e) {
    failed_ = true;
    if (json_)
      output_.line(jsonLine({{"file", member(header, "name")}, {"error", e.what()}}));
    else
      output_.error(std::string("error: ") + e.what());
  }
}

}  // namespace gxy
