// SPDX-License-Identifier: Apache-2.0
#include "tools/gxybench/job.h"

#include "core/scene/state_file.h"

namespace gxy::bench {

nlohmann::json toJson(const Job& job) {
  nlohmann::json settings = nlohmann::json::array();
  for (const Setting& s : job.settings) settings.push_back({s.method, s.label, writeState(s.state)});
  return {{"directory", job.directory}, {"backend", job.backend}, {"device", job.device},
          {"repeats", job.repeats},     {"seconds", job.seconds}, {"threads", job.threads},
          {"pictures", job.pictures},   {"settings", settings}};
}

Job jobOf(const nlohmann::json& json) {
  Job job{json.at("directory"), json.at("backend"), json.at("device"),   json.at("repeats"),
          json.at("seconds"),   json.at("threads"), json.at("pictures"), {}};
  for (const nlohmann::json& s : json.at("settings"))
    job.settings.push_back({s.at(0), s.at(1), readState(s.at(2).get<std::string>(), "job").state});
  return job;
}

nlohmann::json toJson(const Row& row) {
  nlohmann::json json;
  forEachColumn(row, [&](const char* name, const auto& value) { json[name] = value; });
  return json;
}

Row rowOf(const nlohmann::json& json) {
  Row row;
  forEachColumn(row, [&](const char* name, auto& value) { json.at(name).get_to(value); });
  return row;
}

}  // namespace gxy::bench
