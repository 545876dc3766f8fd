// SPDX-License-Identifier: Apache-2.0
#include "tools/msdata/output.h"

#include <unistd.h>

#include <iostream>

#include "multiserver/protocol/json.h"

namespace gxy {

Output::Output() : terminal_(::isatty(STDERR_FILENO) == 1), thread_([this] { run(); }) {}

Output::~Output() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
    changed_.notify_all();
  }
  thread_.join();
  clearProgress();
}

void Output::progress(const std::string& text) {
  if (terminal_) add(Kind::Progress, text);
}

void Output::add(Kind kind, const std::string& text) {
  Item item{kind, protocol::printable(text)};
  const std::lock_guard lock(mutex_);
  waiting_.push_back(std::move(item));
  changed_.notify_all();
}

void Output::flush() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return waiting_.empty() && !printing_; });
  clearProgress();
}

void Output::hold() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return waiting_.empty() && !printing_; });
  held_ = true;
}

void Output::release() {
  const std::lock_guard lock(mutex_);
  held_ = false;
  changed_.notify_all();
}

bool Output::printHeld(const std::function<void()>& before) {
  std::unique_lock lock(mutex_);
  if (waiting_.empty()) return false;
  before();
  printWaiting(lock);
  return true;
}

void Output::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return ending_ || (!held_ && !waiting_.empty()); });
    if (waiting_.empty()) return;
    printWaiting(lock);
  }
}

void Output::printWaiting(std::unique_lock<std::mutex>& lock) {
  std::deque<Item> items;
  items.swap(waiting_);
  printing_ = true;
  lock.unlock();
  for (const Item& item : items) print(item);
  std::cout << std::flush;
  lock.lock();
  printing_ = false;
  changed_.notify_all();
}

void Output::print(const Item& item) {
  clearProgress();
  if (item.kind == Kind::Line) {
    std::cout << item.text << '\n';
    return;
  }
  std::cout << std::flush;
  std::cerr << item.text << (item.kind == Kind::Error ? "\n" : "") << std::flush;
  progressShown_ = item.kind == Kind::Progress;
}

void Output::clearProgress() {
  if (progressShown_) std::cerr << "\r\033[K" << std::flush;
  progressShown_ = false;
}

}  // namespace gxy
