// SPDX-License-Identifier: Apache-2.0
// Which wave runs, of which step, and what views show of it.
#include <algorithm>

#include "core/comm/error_text.h"
#include "core/flow/flow.h"

namespace gxy::flow {

// After every event: ends what has ended, begins what is due, and asks for what that takes.
void Flow::settle() {
  for (bool again = true; again;) {
    dropTargets();
    waiting_.clear();
    if (!wave_) {
      const bool begun = (!preferred_.empty() && beginWave(preferred_)) || beginWave({});
      if (begun) preferred_.clear();
    }
    if (wave_) {
      joinWave();
      showWhatIsThere();
    }
    again = wave_ && wave_->targets.empty();
    if (again) wave_.reset();
  }
  preferred_.clear();
  if (!wave_) forgetRuns();
  work();
  tellStates();
}

// No wave has begun for these: they have to wait for others than files, and run() does not.
void Flow::forgetRuns() {
  std::set<TargetId> waiting;
  for (const Target& target : demanded())
    if (waitsForFile(target)) waiting.insert(target.id);
  std::erase_if(runs_, [&](const auto& item) { return !waiting.contains(item.first); });
  std::erase_if(allowed_, [&](const TargetId& id) { return !waiting.contains(id); });
}

bool Flow::isMissingFile(size_t source) const {
  const DatasetSpec& spec = document_->nodes()[source].spec;
  const auto found = sources_.find(spec.name);
  return !spec.filename.empty() && (found == sources_.end() || !found->second.current) &&
         !stock_.sourceFailures.contains(spec.name);
}

bool Flow::waitsForFile(const Target& target) const {
  return std::any_of(target.sources.begin(), target.sources.end(),
                     [&](size_t source) { return isMissingFile(source); });
}

bool Flow::isDemanded(const TargetId& id) const {
  if (id.kind == TargetId::Kind::Run) return runs_.contains(id);
  if (!document_->target(id)) return false;
  return id.kind == TargetId::Kind::Output || windows_.contains(id.name);
}

std::vector<Target> Flow::demanded() const {
  std::vector<Target> out;
  for (const Target& target : document_->targets()) {
    if (!isDemanded(target.id)) continue;
    out.push_back(target);
    if (const auto window = windows_.find(target.id.name);
        target.id.kind == TargetId::Kind::View && window != windows_.end())
      out.back().follow = target.follow && window->second;
  }
  for (const auto& [id, target] : runs_) out.push_back(target);
  return out;
}

void Flow::dropTargets() {
  for (auto it = shown_.begin(); it != shown_.end();)
    it = isDemanded(it->first) ? std::next(it) : shown_.erase(it);
  if (!wave_) return;
  std::erase_if(wave_->targets, [&](const auto& item) { return !isDemanded(item.first); });
  if (wave_->targets.empty()) wave_.reset();
}

std::vector<SourceData> Flow::candidates(const std::string& source) const {
  const auto found = sources_.find(source);
  if (found == sources_.end() || !found->second.current) return {};
  std::vector<SourceData> out{*found->second.current};
  for (const SourceData& held : holds_.of(out[0].id.object))
    if (held.id < out[0].id) out.push_back(held);
  return out;
}

bool Flow::isAvailable(const SourceData& data) const {
  if (holds_.find(data.id)) return true;
  return std::any_of(sources_.begin(), sources_.end(), [&](const auto& item) {
    return item.second.current && item.second.current->id == data.id;
  });
}

// The newest step for what a target needs, with the preferred generations where there are some. Sources that have failed are left out.
std::optional<Step> Flow::stepFor(const Target& target, const Step& preferred, std::string& why) const {
  Candidates all;
  for (size_t at : target.sources) {
    const std::string& name = document_->nodes()[at].spec.name;
    std::vector<SourceData> list = candidates(name);
    if (list.empty()) {
      const bool isRun = target.id.kind == TargetId::Kind::Run;
      if ((isRun && !isMissingFile(at)) || stock_.sourceFailures.contains(name)) continue;
      why = "for " + inQuotes(name);
      return std::nullopt;
    }
    const auto wish = preferred.find(name);
    if (wish != preferred.end() && wish->second.id.object == list[0].id.object && isAvailable(wish->second))
      list = {wish->second};
    all.emplace(name, std::move(list));
  }
  return newestStep(all, why);
}

Picture Flow::pictureFor(const Target& target, const Step& step) const {
  return pictureOf(*document_, target, outcomes(*keys_, target.closure, step, stock_), step, stock_);
}

bool Flow::showsAll(const Shown& shown, const Picture& picture) {
  return !picture.isPending && picture == shown.picture;
}

// The step that a target is to show; nothing if it shows it, or cannot show any.
std::optional<Step> Flow::dueStep(const Target& target, const Step& preferred) {
  waiting_.erase(target.id);
  const auto found = shown_.find(target.id);
  const Shown* shown = found != shown_.end() && found->second.hasPicture ? &found->second : nullptr;
  if (shown && shown->isHeld && !shown->isWritten) shown = nullptr;
  if (shown && !target.follow && !found->second.isAsked) {
    const bool hasAll = std::all_of(target.sources.begin(), target.sources.end(), [&](size_t source) {
      return shown->step.contains(document_->nodes()[source].spec.name);
    });
    if (hasAll && showsAll(*shown, pictureFor(target, shown->step))) return std::nullopt;
  }
  std::string why;
  const std::optional<Step> step = stepFor(target, preferred, why);
  if (!step) {
    waiting_[target.id] = why;
    return std::nullopt;
  }
  if (target.id.kind == TargetId::Kind::Run) return step;
  if (shown && showsAll(*shown, pictureFor(target, *step))) {
    found->second.isAsked = false;
    return std::nullopt;
  }
  return step;
}

bool Flow::beginWave(const Step& preferred) {
  struct Due {
    uint64_t last;  // wave that it has shown
    Target target;
    Step step;
  };
  std::vector<Due> due;
  for (const Target& target : demanded()) {
    const std::optional<Step> step = dueStep(target, preferred);
    if (!step) continue;
    if (!isAllowed(target.id)) {
      waiting_[target.id] = "paused";
      continue;
    }
    const bool isRun = target.id.kind == TargetId::Kind::Run;
    const auto found = shown_.find(target.id);
    due.push_back({isRun ? UINT64_MAX : found == shown_.end() ? 0 : found->second.wave, target, *step});
  }
  if (due.empty()) return false;
  std::stable_sort(due.begin(), due.end(), [](const Due& a, const Due& b) { return a.last < b.last; });
  wave_.emplace(++waves_, revision_, isLive_ && revision_ > evaluatedRevision_, keys_);
  evaluatedRevision_ = revision_;
  for (const Due& item : due)
    if (areOneStep(wave_->step, item.step)) addTarget(item.target, item.step);
  return true;
}

// A target that wants the same step need not wait until the wave has ended.
void Flow::joinWave() {
  if (wave_->keys != keys_) return;
  for (const Target& target : demanded()) {
    if (wave_->targets.contains(target.id)) continue;
    const std::optional<Step> step = dueStep(target, {});
    if (!step) continue;
    if (!isAllowed(target.id))
      waiting_[target.id] = "paused";
    else if (areOneStep(wave_->step, *step))
      addTarget(target, *step);
    else
      waiting_[target.id] = "for the wave that runs";
  }
}

void Flow::addTarget(const Target& target, const Step& step) {
  wave_->targets.emplace(target.id, target);
  for (const auto& [name, data] : step) {
    wave_->step.emplace(name, data);
    Source& source = sources_[name];
    if (source.current && source.current->id == data.id) source.isTaken = true;
  }
}

void Flow::showWhatIsThere() {
  const CompiledDocument& document = wave_->keys->document();
  std::vector<std::pair<Target, std::vector<Outcome>>> all;
  for (const auto& [id, target] : wave_->targets) {
    all.emplace_back(target, outcomes(*wave_->keys, target.closure, wave_->step, stock_));
    rememberGood(all.back().second);
  }
  for (const auto& [target, outcomes] : all) {
    const Picture picture = pictureOf(document, target, outcomes, wave_->step, stock_);
    const bool isRun = target.id.kind == TargetId::Kind::Run;
    if (!picture.isPending) {
      wave_->targets.erase(target.id);
      allowed_.erase(target.id);
      runs_.erase(target.id);
    }
    if (isRun || (picture.isPending && (!target.asItComes || picture.data.empty()))) continue;
    Shown& shown = shown_[target.id];
    const bool isNew = !shown.hasPicture || shown.isHeld || shown.picture.data != picture.data ||
                       shown.picture.problems != picture.problems;
    shown.picture = picture;
    shown.step = wave_->step;
    shown.hasPicture = true;
    if (!picture.isPending) shown.isAsked = false;
    if (!isNew) continue;
    shown.wave = wave_->number;
    shown.isHeld = shown.isWritten = false;
    showing_[target.id] = ShowData{target.id, wave_->number, wave_->revision, picture.data, picture.problems};
    for (const ShownData& item : picture.data)
      if (const auto* key = std::get_if<NodeKey>(&item.data)) stock_.outputs.use(*key);
  }
}

void Flow::rememberGood(const std::vector<Outcome>& outcomes) {
  const std::vector<Node>& nodes = wave_->keys->document().nodes();
  for (size_t at = 0; at < outcomes.size(); at++)
    if (outcomes[at].kind == Outcome::Kind::There)
      if (const auto* key = std::get_if<NodeKey>(&outcomes[at].data))
        if (document_->place(nodes[at].spec.name)) stock_.lastGood[nodes[at].spec.name] = *key;
}

}  // namespace gxy::flow
