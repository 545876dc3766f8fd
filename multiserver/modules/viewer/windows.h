// SPDX-License-Identifier: Apache-2.0
// The windows of a session.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "core/comm/error.h"
#include "multiserver/modules/viewer/window.h"
#include "multiserver/server/module.h"

namespace gxy::viewer {

using WindowPtr = std::shared_ptr<Window>;

/// A session's windows. Its end closes them; they render no more from when its client has gone.
class Windows {
 public:
  explicit Windows(Session& session) : session_(session) {
    // The observer may still be running when the session ends. So it looks whether the list is still there.
    subscription_ = session.serverRank().datasets->observe(
        [weak = std::weak_ptr(list_), tenant = session.tenant()](const DatasetEvent& event) {
          const auto list = weak.lock();
          if (!list || !event.visibleTo(tenant)) return;
          for (const auto& [id, window] : list->all()) window->onData(event);
        });
    // Windows are told whatever the tenant can see now: they may still show data that it no longer sees.
    wanted_ =
        session.serverRank().observers.subscribe({}, [weak = std::weak_ptr(list_)](const ObjectEvent& event) {
          if (event.kind != ObjectEvent::Kind::Wanted) return;
          if (const auto list = weak.lock())
            for (const auto& [id, window] : list->all()) window->onWanted(event.key, event.generation);
        });
    // The session ends after all its requests, which may take a while.
    session.outbox().onClose([weak = std::weak_ptr(list_), &transport = session.serverRank().transport] {
      transport.post([weak] {
        if (const auto list = weak.lock()) list->endFrames();
      });
    });
  }
  ~Windows() {
    subscription_ = nullptr;
    wanted_.end();
    list_->endFrames();
    for (const auto& [id, window] : list_->all()) window->close();
  }

  std::map<uint32_t, WindowPtr> all() const { return list_->all(); }
  WindowPtr get(uint32_t id) const {
    const std::lock_guard lock(list_->mutex);
    const auto at = list_->windows.find(id);
    if (at == list_->windows.end())
      throw Error("window " + std::to_string(id) + ": there is none, expected one made by `window`");
    return at->second;
  }
  WindowPtr make(uint32_t id, Services& services, const std::shared_ptr<Outbox>& outbox) {
    const std::lock_guard lock(list_->mutex);
    auto& windows = list_->windows;
    if (const auto at = windows.find(id); at != windows.end()) return at->second;
    if (windows.size() >= session_.limits().windows)
      throw Error("window " + std::to_string(id) + ": there are " + std::to_string(windows.size()) +
                  ", expected no more; `close` one");
    return windows[id] = std::make_shared<Window>(services, outbox, session_.tenant(), id);
  }
  void close(uint32_t id) {
    get(id)->close();
    const std::lock_guard lock(list_->mutex);
    list_->windows.erase(id);
  }

 private:
  struct List {
    mutable std::mutex mutex;
    std::map<uint32_t, WindowPtr> windows;
    std::map<uint32_t, WindowPtr> all() const {
      const std::lock_guard lock(mutex);
      return windows;
    }
    // Of all windows before any of them is waited for.
    void endFrames() const {
      for (const auto& [id, window] : all()) window->endFrames();
    }
  };
  Session& session_;
  const std::shared_ptr<List> list_ = std::make_shared<List>();
  std::shared_ptr<void> subscription_;
  Observers::Subscription wanted_;
};

}  // namespace gxy::viewer
