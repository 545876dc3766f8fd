// SPDX-License-Identifier: Apache-2.0
#include "core/comm/completion.h"

#include <string>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/tree.h"
#include "core/comm/wire.h"

namespace gxy {

namespace {

enum class Kind : uint8_t {
  Wave,    ///< to the children: answer when idle
  Answer,  ///< to the parent: the sums of a subtree
  Done,    ///< to the children: forget the set
};

struct Message {
  Kind kind;
  SetId set;
  uint64_t created, retired;
};

Bytes encode(const Message& message) {
  Writer writer;
  return writer.write(message.kind).write(message.set).write(message.created).write(message.retired).take();
}

Message decode(const Bytes& bytes) {
  Reader reader(bytes, "completion");
  Message message;
  message.kind = reader.read<Kind>();
  message.set = reader.read<SetId>();
  message.created = reader.read<uint64_t>();
  message.retired = reader.read<uint64_t>();
  reader.expectEnd();
  return message;
}

}  // namespace

/// One rank's state of one set.
struct Completion::Set {
  explicit Set(SetId id) : id(id) {}

  const SetId id;
  std::atomic<uint64_t> created = 0, retired = 0;

  /// The number of reasons why the rank is not idle: its token while it is not retired, and each open Active.
  std::atomic<int64_t> busy = 1;

  /// A wave has arrived and has not been answered. It is written under the mutex. The worker that ends last
  /// reads it without the mutex: it changes `busy`, then reads `waiting`. The wave's arrival sets `waiting`,
  /// then reads `busy`. So at least one of the two sees that both conditions hold, and answers.
  std::atomic<bool> waiting = false;

  std::mutex mutex;  ///< guards the members below
  int childrenToAnswer = 0;
  uint64_t createdBelow = 0, retiredBelow = 0;  ///< sums of the children's answers to this wave

  std::function<void()> onDone;  ///< used on rank 0 only
  /// Used on rank 0 only. The created sum is at least 1, so the initial 0 never ends a set at its first wave.
  uint64_t retiredLastWave = 0;
};

Completion::Completion(Transport& transport, Rule rule, Channel channel)
    : transport_(transport), rule_(rule), channel_(channel) {
  transport_.onMessage(channel_, [this](int, Bytes message) { receive(std::move(message)); });
}

Completion::~Completion() { transport_.onMessage(channel_, nullptr); }

std::shared_ptr<Completion::Set> Completion::find(SetId id) {
  {
    std::shared_lock lock(mutex_);
    if (const auto found = sets_.find(id); found != sets_.end()) return found->second;
  }
  std::unique_lock lock(mutex_);
  auto& set = sets_[id];
  if (!set) {
    set = std::make_shared<Set>(id);
    if (!rule_.tokensAtRoot) set->busy = 0;
  }
  return set;
}

size_t Completion::setsKept() const {
  std::shared_lock lock(mutex_);
  return sets_.size();
}

// ----------------------------------------------------------------------------------------------------------
// counting

void Completion::begin(SetId id, std::function<void()> onDone) {
  if (transport_.rank() != 0)
    throw Error("Completion::begin was called on rank " + std::to_string(transport_.rank()) +
                ", expected rank 0");
  const auto set = find(id);
  {
    std::lock_guard lock(set->mutex);
    if (set->onDone) throw Error("Completion::begin: set " + std::to_string(id) + " has begun before");
    set->onDone = std::move(onDone);
  }
  if (rule_.tokensAtRoot) set->created += uint64_t(transport_.size());
  startWave(*set);
}

void Completion::created(SetId id, uint64_t n) { find(id)->created += n; }
void Completion::retired(SetId id, uint64_t n) { find(id)->retired += n; }

void Completion::spawned(SetId id) {
  if (!rule_.tokensAtRoot) return;
  const auto set = find(id);
  ++set->retired;
  if (--set->busy == 0 && set->waiting) answerIfIdle(*set);
}

Completion::Active::Active(Completion& completion, SetId set)
    : completion_(completion), set_(completion.find(set)) {
  ++set_->busy;
}

Completion::Active::~Active() {
  if (set_ && --set_->busy == 0 && set_->waiting) completion_.answerIfIdle(*set_);
}

// -------------------------------------------------------------------------------------------------------------
// waves

void Completion::receive(Bytes bytes) {
  const Message message = decode(bytes);
  switch (message.kind) {
    case Kind::Wave:
      return receiveWave(*find(message.set));
    case Kind::Answer:
      return receiveAnswer(*find(message.set), message.created, message.retired);
    case Kind::Done:
      return receiveDone(message.set);
  }
  throw Error("malformed message 'completion': its kind is " + std::to_string(int(message.kind)) +
              ", expected 0 to 2");
}

void Completion::sendDown(const Bytes& message) {
  forEachTreeChild(transport_.rank(), 0, transport_.size(),
                   [&](int child) { transport_.send(child, channel_, message); });
}

void Completion::startWave(Set& set) {
  ++waves_;
  transport_.send(0, channel_, encode({Kind::Wave, set.id, 0, 0}));
}

void Completion::receiveWave(Set& set) {
  {
    std::lock_guard lock(set.mutex);
    set.createdBelow = set.retiredBelow = 0;
    set.childrenToAnswer = treeChildren(transport_.rank(), 0, transport_.size());
    set.waiting = true;
  }
  sendDown(encode({Kind::Wave, set.id, 0, 0}));
  answerIfIdle(set);
}

void Completion::receiveAnswer(Set& set, uint64_t created, uint64_t retired) {
  {
    std::lock_guard lock(set.mutex);
    set.createdBelow += created;
    set.retiredBelow += retired;
    --set.childrenToAnswer;
  }
  answerIfIdle(set);
}

void Completion::answerIfIdle(Set& set) {
  uint64_t created, retired;
  {
    std::lock_guard lock(set.mutex);
    const bool idle = set.busy == 0 || !rule_.answersWhenIdle;
    if (!set.waiting || set.childrenToAnswer > 0 || !idle) return;
    set.waiting = false;
    created = set.createdBelow + set.created;
    retired = set.retiredBelow + set.retired;
  }
  if (transport_.rank() == 0)
    concludeWave(set, created, retired);
  else
    transport_.send(treeParent(transport_.rank(), 0, transport_.size()), channel_,
                    encode({Kind::Answer, set.id, created, retired}));
}

void Completion::concludeWave(Set& set, uint64_t created, uint64_t retired) {
  const uint64_t before = rule_.comparesTwoWaves ? set.retiredLastWave : retired;
  if (before != created) {
    set.retiredLastWave = retired;
    startWave(set);
    return;
  }
  transport_.send(0, channel_, encode({Kind::Done, set.id, 0, 0}));
}

void Completion::receiveDone(SetId id) {
  sendDown(encode({Kind::Done, id, 0, 0}));
  std::shared_ptr<Set> set;
  {
    std::unique_lock lock(mutex_);
    if (const auto found = sets_.extract(id)) set = found.mapped();
  }
  if (set && set->onDone) set->onDone();
}

}  // namespace gxy
