// SPDX-License-Identifier: Apache-2.0
#include "core/comm/trace.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace gxy {

void Trace::Span::start(std::string_view name, uint64_t value) {
  name_ = name;
  value_ = value;
  begin_ = Clock::now();
}

void Trace::Span::end() { trace_->add(name_, value_, begin_, false); }

void Trace::addLong(std::string_view name, uint64_t id, Clock::time_point begin) {
  add(name, id, begin, true);
}

void Trace::add(std::string_view name, uint64_t value, Clock::time_point begin, bool isLong) {
  Event event{{}, begin, Clock::now(), value, gettid(), isLong};
  // Characters that JSON would need escaped become '_'.
  std::transform(name.begin(), name.begin() + std::min(name.size(), event.name.size() - 1),
                 event.name.begin(),
                 [](char c) { return c < 0x20 || c == '"' || c == '\\' || c > 0x7e ? '_' : c; });
  const std::lock_guard lock(mutex_);
  if (events_.size() < most_) return events_.push_back(event);
  events_[oldest_] = event;
  oldest_ = (oldest_ + 1) % most_;
}

std::string Trace::events(int rank) const {
  std::vector<Event> events;
  {
    const std::lock_guard lock(mutex_);
    events = events_;
  }
  const auto microseconds = [this](Clock::time_point t) {
    return double((t.time_since_epoch() + ahead_).count()) / 1000;
  };
  std::string text;
  char line[256];
  std::snprintf(line, sizeof line, R"({"ph":"M","name":"process_name","pid":%d,"args":{"name":"rank %d"}})",
                rank, rank);
  text = line;
  for (const Event& e : events) {
    const double begin = microseconds(e.begin), end = microseconds(e.end);
    const auto id = static_cast<unsigned long long>(e.value);
    if (!e.isLong) {
      std::snprintf(line, sizeof line,
                    R"({"ph":"X","name":"%s","pid":%d,"tid":%d,"ts":%.3f,"dur":%.3f,"args":{"value":%llu}})",
                    e.name.data(), rank, e.thread, begin, end - begin, id);
      text.append(",\n").append(line);
      continue;
    }
    for (const auto& [phase, time] : {std::pair('b', begin), std::pair('e', end)}) {
      std::snprintf(line, sizeof line,
                    R"({"ph":"%c","cat":"%s","name":"%s","id":%llu,"pid":%d,"tid":%d,"ts":%.3f})", phase,
                    e.name.data(), e.name.data(), id, rank, e.thread, time);
      text.append(",\n").append(line);
    }
  }
  return text;
}

std::string Trace::document(const std::vector<std::string>& eventsOfRanks) {
  std::string text = "{\"traceEvents\":[\n";
  for (size_t i = 0; i < eventsOfRanks.size(); i++) text.append(i ? ",\n" : "").append(eventsOfRanks[i]);
  return text + "\n]}\n";
}

}  // namespace gxy
