// SPDX-License-Identifier: Apache-2.0
#include "insitu/client/connection.h"

#include <pthread.h>

#include <csignal>
#include <utility>

#include "core/comm/crc32c.h"
#include "core/comm/error.h"

namespace gxy::insitu {

using protocol::MessageChannel;
using protocol::WireMessage;

namespace {

using Clock = Interrupt::Clock;
constexpr std::chrono::seconds kConnectPatience(10);

WireMessage message(MessageChannel channel, Bytes payload) { return {channel, 0, std::move(payload)}; }

}  // namespace

std::byte* Slot::reserve(uint64_t bytes) {
  if (bytes > bytes_) {
    data_.reset();
    bytes_ = 0;
    data_ = std::make_unique_for_overwrite<std::byte[]>(bytes);
    bytes_ = bytes;
  }
  return data_.get();
}

std::shared_ptr<const Route> withLoads(Route route, const std::vector<Mesh>& meshes) {
  const std::vector<Mesh> sent = encoded(meshes, route.encodings);
  route.loads.clear();
  for (const Destination& d : route.destinations) route.loads.push_back({d.owner, itemsOf(d.pieces, sent)});
  return std::make_shared<const Route>(std::move(route));
}

Connection::Connection(Options options, Member member)
    : options_(std::move(options)), member_(std::move(member)), thread_(started(*this)) {}

// Signals of the process are for its own threads.
std::thread Connection::started(Connection& connection) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const std::shared_ptr<void> restore(nullptr,
                                      [&](void*) { pthread_sigmask(SIG_SETMASK, &before, nullptr); });
  return std::thread([&connection] { connection.run(); });
}

Connection::~Connection() {
  if (!thread_.joinable()) return;
  interrupt_.close();
  thread_.join();
}

void Connection::describe(Description description) {
  {
    const std::lock_guard lock(mutex_);
    description.from = sender_.count() + 1;
    description_ = std::move(description);
  }
  interrupt_.wake();
}

std::shared_ptr<const Route> Connection::route() const {
  const std::lock_guard lock(mutex_);
  return isPlanned() ? route_ : nullptr;
}

// With the lock held.
bool Connection::isPlanned() const { return route_ && description_ && route_->from >= description_->from; }

// Whether the next publish can be taken; or a later one is appointed, so that the next one will not be, unless it is the last of
// all. With the lock held.
bool Connection::isDueNow(Loss loss) const {
  return sender_.isDue() && (isPlanned() || (loss == Loss::EndsTheWait && !sender_.isNext()));
}

void Connection::filled(int64_t step, double time, Counts counts) {
  sender_.filled(step, time, std::move(counts));
  interrupt_.wake();
}

void Connection::notFilled(bool late) {
  sender_.notFilled(late);
  interrupt_.wake();
}

std::string Connection::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

Steering Connection::steering() const {
  const std::lock_guard lock(mutex_);
  return steering_;
}

bool Connection::lost() const {
  const std::lock_guard lock(mutex_);
  return lost_;
}

void Connection::end() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  changed_.notify_all();
}

bool Connection::await(Clock::time_point until, Loss loss) {
  {
    const std::lock_guard lock(mutex_);
    if (isDueNow(loss)) return true;
  }
  if (loss == Loss::EndsTheWait && lost()) return false;
  sender_.await();
  interrupt_.wake();
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, until,
                      [&] { return isDueNow(loss) || ended_ || (lost_ && loss == Loss::EndsTheWait); });
  return sender_.isDue();
}

void Connection::settle(Clock::time_point until) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, until, [this] { return sender_.idle(); });
}

void Connection::close() {
  interrupt_.close();
  thread_.join();
}

void Connection::run() {
  for (;;) {
    try {
      serve();
    } catch (const Closing&) {
      sayBye();
      return;
    } catch (const std::exception& e) {
      lose(e.what());
    }
    if (options_.reconnect.count() == 0 || over_) return end();
    try {
      const auto until = Clock::now() + std::chrono::duration_cast<Clock::duration>(options_.reconnect);
      while (Clock::now() < until) {
        pollfd none{};
        interrupt_.wait(std::span(&none, 1), until);
      }
    } catch (const Closing&) {
      return;
    }
  }
}

void Connection::lose(const std::string& why) {
  connected_ = false;
  sender_.begin();
  sockets_.clear();
  described_ = 0;
  planned_ = false;
  const std::lock_guard lock(mutex_);
  route_.reset();
  problem_ = why;
  lost_ = true;
  changed_.notify_all();
}

// Until the connection is lost.
void Connection::serve() {
  joined_ = join(options_, member_, interrupt_);
  follow(joined_, {{0, {}}});
  connected_ = true;
  for (;;) {
    exchange();
    waitForSockets();
    for (const auto& [owner, socket] : sockets_)  // may get more of them meanwhile
      receive(owner, *socket);
  }
}

// Connects to the ranks of the server that get something.
void Connection::follow(const Joined& joined, std::vector<Destination> destinations) {
  for (const Destination& d : destinations) {
    if (sockets_.count(d.owner) > 0) continue;
    if (size_t(d.owner) >= joined.ranks.size()) throw Error("plan of a stream: there is no such rank");
    const auto& [host, port] = joined.ranks[size_t(d.owner)];
    auto socket = std::make_unique<WireSocket>(host, port, protocol::Purpose::Data, interrupt_,
                                               Clock::now() + kConnectPatience);
    socket->send(
        message(MessageChannel::DataHello,
                written(Hello{joined.stream, joined.ticket, uint32_t(member_.rank), checksumOf(*socket)})));
    sockets_.emplace(d.owner, std::move(socket));
  }
}

// Sends what there is to send, as much as the sockets take.
void Connection::exchange() {
  WireSocket& root = *sockets_.at(0);
  if (described_ == 0) tellDescription(root);  // others when the server asks, or this rank waits
  while (const auto answer = sender_.answer()) tellRoot(*answer);
  if (described_ > 0)
    if (const auto waits = sender_.waits()) tellRoot(*waits);
  if (const auto step = sender_.announcement()) root.send(message(MessageChannel::Step, written(*step)));
  for (const auto& [owner, socket] : sockets_) sendPieces(owner, *socket);
}

void Connection::tellDescription(WireSocket& root) {
  const std::lock_guard lock(mutex_);
  if (!description_ || description_->from == described_) return;
  root.send(message(MessageChannel::Describe, written(*description_)));
  described_ = description_->from;
}

// The server relies on it that a rank which says how far it is has said what it has before.
void Connection::tellRoot(const Control& control) {
  WireSocket& root = *sockets_.at(0);
  tellDescription(root);
  root.send(message(MessageChannel::DataControl, written(control)));
}

// A network changes a bit now and then that TCP's 16 bits do not show; memory of this machine does not go through one.
Checksum Connection::checksumOf(const WireSocket& socket) const {
  return options_.checksum.value_or(!socket.isLoopback()) ? Checksum::Crc32c : Checksum::None;
}

// One chunk at a time waits in a socket's queue, so that what the server says is heard between chunks. Afterwards something waits in the
// queue, or there is nothing more to send: else nobody would wake this thread to send the rest.
void Connection::sendPieces(int owner, WireSocket& socket) {
  socket.flush();
  while (socket.sent()) {
    auto chunk = sender_.next(owner);
    if (!chunk) return;
    const std::span<const std::byte> samples(route_->slot->data() + chunk->place, chunk->bytes);
    if (checksumOf(socket) == Checksum::Crc32c) chunk->header.checksum = crc32c(samples);
    const auto header = written(chunk->header);
    socket.send(message(MessageChannel::Piece, Bytes(header.begin(), header.end())), samples);
    socket.flush();
  }
}

void Connection::waitForSockets() {
  std::vector<pollfd> sockets;
  for (const auto& [owner, socket] : sockets_)
    sockets.push_back({socket->descriptor(), short(socket->sent() ? POLLIN : POLLIN | POLLOUT), 0});
  sockets.emplace_back();
  interrupt_.wait(sockets);
}

void Connection::receive(int owner, WireSocket& socket) {
  while (const auto m = socket.receive()) {
    if (m->channel == MessageChannel::Bye) {
      over_ = m->text().starts_with(kClosedBy);
      throw Error(std::string(m->text()));
    }
    if (owner != 0) throw Error("the server's rank " + std::to_string(owner) + " says what only rank 0 may");
    if (m->channel == MessageChannel::Steer) {
      const std::lock_guard lock(mutex_);
      steering_ = readSteering(m->payload);
      continue;
    }
    if (m->channel == MessageChannel::Encode) {
      receiveEncodings(m->payload);
      continue;
    }
    if (m->channel == MessageChannel::DataControl) {
      receiveControl(readControl(m->payload));
      continue;
    }
    receivePlan(m->payload);
  }
}

void Connection::receivePlan(std::span<const std::byte> message) {
  if (described_ == 0) throw Error("plan of a stream before a description, expected it after that");
  const uint64_t from = takeFrom(message);
  std::shared_ptr<const Route> route;
  {
    const std::lock_guard lock(mutex_);
    problem_.clear();  // and not before: the server may have refused the plan
    lost_ = false;
    if (from < description_->from)
      return;  // The server will know soon that this rank has something else now.
    Route next = route_ ? *route_ : Route{0, {}, {}, {}, std::make_shared<Slot>()};
    next.from = from;
    next.destinations = readDestinations(message, member_.rank, *description_);
    route = withLoads(std::move(next), description_->meshes);
  }
  follow(joined_, route->destinations);
  sender_.expect(route->loads);
  if (!std::exchange(planned_, true) && options_.patience.count() > 0)
    tellRoot({Control::Kind::Waits, 0, 0});  // The server knows from now on that no step may be left out.
  const std::lock_guard lock(mutex_);
  route_ = std::move(route);
  changed_.notify_all();
}

// The server appoints the next step after this.
void Connection::receiveEncodings(std::span<const std::byte> message) {
  std::shared_ptr<const Route> next;
  {
    const std::lock_guard lock(mutex_);
    if (!route_) throw Error("encodings of a stream before its plan, expected them after it");
    const std::vector<Mesh>& meshes = description_->meshes;  // whose fields do not change any more
    Route other = *route_;
    other.encodings = readEncodings(message, meshes);
    next = withLoads(std::move(other), meshes);
  }
  sender_.expect(next->loads);
  const std::lock_guard lock(mutex_);
  route_ = std::move(next);
}

void Connection::receiveControl(const Control& control) {
  // The slot may be filled anew after this, so that nothing may be sent from it any more.
  if (control.kind == Control::Kind::Cancel || control.kind == Control::Kind::Published)
    for (const auto& [owner, socket] : sockets_) socket->own();
  if (const auto answer = sender_.receive(control)) tellRoot(*answer);
  const std::lock_guard lock(mutex_);
  changed_.notify_all();
}

// The server knows then that this rank has not failed.
void Connection::sayBye() {
  connected_ = false;
  const auto end = Clock::now() + std::chrono::milliseconds(500);
  for (const bool wait : {false, true})
    for (const auto& [owner, socket] : sockets_) try {
        if (!wait)
          socket->send(protocol::textMessage(MessageChannel::Bye, 0, "the simulation has closed the stream"));
        socket->finish(wait ? end : Clock::now());
      } catch (const std::exception&) {
        // lost already
      }
  sockets_.clear();
}

}  // namespace gxy::insitu
