// SPDX-License-Identifier: Apache-2.0
// What a graph promises of keys, demand, edits, states and memory, one sentence at a time.
#include <algorithm>

#include "core/comm/error.h"
#include "tests/flow/flow_fixture.h"

namespace gxy::flow {
namespace {

// 1. Keys

TEST_F(FlowTest, UndoFindsTheOldOutput) {
  flow_.show("v");
  flow_.update("a", data(1, 1));
  const Document first{{live("a"), shift("b", "a", 1)}, {{"v", {"b"}}}, {}};
  Document second = first;
  second.datasets[1].properties = by(2);
  flow_.edit(first);
  finishAll();
  flow_.edit(second);
  EXPECT_EQ(started(), Names{"b"});
  finish("b");
  flow_.take();
  flow_.edit(first);
  EXPECT_EQ(taken<ShowData>().size(), 1u);
  EXPECT_TRUE(among<StartEvaluation>().empty());
}

TEST_F(FlowTest, EqualNodesShareOneEvaluation) {
  flow_.show("v");
  flow_.edit({{live("a"), shift("b", "a"), shift("c", "a")}, {{"v", {"b", "c"}}}, {}});
  flow_.update("a", data(1, 1));
  EXPECT_EQ(started(), Names{"b"});
  finish("b");
  const auto shown = taken<ShowData>();
  ASSERT_EQ(shown.size(), 1u);
  EXPECT_EQ(shown[0].data.at(0).data, shown[0].data.at(1).data);
}

TEST_F(FlowTest, AnotherObjectOfTheSameNameIsAnotherInput) {
  flow_.show("v");
  flow_.edit({{live("a"), shift("b", "a")}, {{"v", {"b"}}}, {}});
  flow_.update("a", data(1, 1));
  finishAll();
  flow_.dropped("a");
  EXPECT_EQ(state("b").kind, State::Waiting);
  flow_.update("a", data(2, 1));
  EXPECT_EQ(started(), Names{"b"});
}

// 2. Demand

TEST_F(FlowTest, NothingRunsOrIsPinnedWithoutAWindowOrAnOutput) {
  flow_.edit({{live("a"), shift("b", "a")}, {{"v", {"a", "b"}}}, {}});
  flow_.update("a", data(1, 1));
  EXPECT_TRUE(started().empty());
  EXPECT_TRUE(among<PinGeneration>().empty());
  flow_.show("v");
  EXPECT_EQ(started(), Names{"b"});
  EXPECT_EQ(among<PinGeneration>().size(), 1u);
  flow_.hide("v");
  EXPECT_EQ(taken<CancelEvaluation>().size(), 1u);
  flow_.cancelled(numbers_["b"]);
  EXPECT_EQ(taken<ReleaseGeneration>().size(), 1u);
}

TEST_F(FlowTest, AnOutputNeedsItsDataUntilItIsWritten) {
  flow_.edit({{live("a"), shift("b", "a")}, {}, {{"o", "a"}}});
  flow_.update("a", data(1, 1));
  const auto shown = taken<ShowData>();
  ASSERT_EQ(shown.size(), 1u);
  EXPECT_EQ(shown[0].target.kind, TargetId::Kind::Output);
  EXPECT_TRUE(among<ReleaseGeneration>().empty());
  flow_.written("o", shown[0].wave);
  EXPECT_EQ(taken<ReleaseGeneration>().size(), 1u);
  EXPECT_TRUE(among<ShowData>().empty());
}

TEST_F(FlowTest, APausedGraphEvaluatesOnRunOnly) {
  flow_.pause();
  flow_.show("v");
  flow_.edit({{live("a"), shift("b", "a"), shift("c", "b")}, {{"v", {"b"}}}, {}});
  flow_.update("a", data(1, 1));
  EXPECT_TRUE(started().empty());
  EXPECT_EQ(viewState("v").text, "paused");
  flow_.run();
  EXPECT_EQ(started(), Names{"b"});
  finish("b");
  EXPECT_EQ(started(), Names{"c"}) << "run evaluates all nodes";
  finish("c");
  flow_.update("a", data(1, 2));
  EXPECT_TRUE(started().empty());
  EXPECT_EQ(state("b").kind, State::Stale);
  flow_.resume();
  EXPECT_EQ(started(), Names{"b"});
}

TEST_F(FlowTest, AFileIsFetchedWhenSomethingNeedsIt) {
  DatasetSpec file = live("f");
  file.filename = "f.vti";
  flow_.edit({{file, shift("b", "f")}, {{"v", {"b"}}}, {}});
  EXPECT_TRUE(taken<FetchSource>().empty());
  flow_.show("v");
  EXPECT_EQ(taken<FetchSource>().size(), 1u);
  flow_.sourceFailed("f", "cannot read f.vti", 2);
  EXPECT_EQ(state("f").kind, State::Failed);
  EXPECT_EQ(viewState("v").by, "f");
  flow_.run();
  EXPECT_EQ(taken<FetchSource>().size(), 1u);
  flow_.update("f", data(1, 1));
  EXPECT_EQ(started(), Names{"b"});
}

TEST_F(FlowTest, AnotherFileOfTheSameNameIsFetched) {
  flow_.show("v");
  DatasetSpec file = live("f");
  file.filename = "f.vti";
  Document document{{file, shift("b", "f")}, {{"v", {"b"}}}, {}};
  flow_.edit(document);
  flow_.update("f", data(1, 1));
  finishAll();
  document.datasets[0].filename = "g.vti";
  flow_.edit(document);
  EXPECT_EQ(taken<FetchSource>().size(), 1u);
  EXPECT_EQ(state("f").kind, State::Waiting);
}

TEST_F(FlowTest, RunLeavesOutWhatReadsASourceThatIsNotThere) {
  flow_.edit({{live("a"), live("gone"), shift("b", "a"), shift("c", "gone")}, {}, {}});
  flow_.update("a", data(1, 1));
  flow_.run();
  EXPECT_EQ(started(), Names{"b"});
  finish("b");
  EXPECT_EQ(state("c").text, "for \"gone\"");
  flow_.update("gone", data(2, 1));
  EXPECT_TRUE(started().empty()) << "run asks once";
}

TEST_F(FlowTest, AViewThatDoesNotFollowTakesNewDataWithAnEditOnly) {
  flow_.show("v");
  Document document{{live("a"), shift("b", "a")}, {{"v", {"b"}, false}}, {}};
  flow_.edit(document);
  flow_.update("a", data(1, 1));
  finishAll();
  flow_.update("a", data(1, 2));
  EXPECT_TRUE(started().empty());
  document.datasets[1].properties = by(5);
  flow_.edit(document);
  const auto starts = taken<StartEvaluation>();
  ASSERT_EQ(starts.size(), 1u);
  EXPECT_EQ(starts[0].inputs[0].items[0].data, DataId(SourceGeneration{{1}, 2}));
}

// 4. Edits

TEST_F(FlowTest, AnEditCancelsObsoleteKeysOnlyAndKeepsTheStep) {
  flow_.show("v");
  const Document first{{live("a"), shift("b", "a", 1), shift("c", "a", 2)}, {{"v", {"b", "c"}}}, {}};
  Document second = first;
  second.datasets[2].properties = by(3);
  flow_.edit(first);
  flow_.update("a", data(1, 1));
  EXPECT_EQ(started(), (Names{"b", "c"}));
  const uint64_t c = numbers_["c"];
  flow_.update("a", data(1, 2));
  flow_.edit(second);
  const auto cancels = taken<CancelEvaluation>();
  ASSERT_EQ(cancels.size(), 1u);
  EXPECT_EQ(cancels[0].evaluation, c);
  flow_.cancelled(c);
  const auto starts = taken<StartEvaluation>();
  ASSERT_EQ(starts.size(), 1u);
  EXPECT_EQ(starts[0].inputs[0].items[0].data, DataId(SourceGeneration{{1}, 1}));
}

TEST_F(FlowTest, LiveEditsAreEvaluatedOneAtATimeAndTheLastAlways) {
  flow_.show("v");
  Document document{{live("a"), shift("b", "a", 0)}, {{"v", {"b"}}}, {}};
  flow_.update("a", data(1, 1));
  flow_.edit(document, true);
  EXPECT_EQ(started(), Names{"b"});
  for (int amount = 1; amount <= 5; amount++) {
    document.datasets[1].properties = by(amount);
    flow_.edit(document, true);
  }
  EXPECT_TRUE(taken<CancelEvaluation>().empty());
  finish("b");
  const auto starts = taken<StartEvaluation>();
  EXPECT_EQ(among<ShowData>().size(), 1u);
  ASSERT_EQ(starts.size(), 1u);
  EXPECT_EQ(starts[0].properties, R"({"by":5.0})");
  document.datasets[1].properties = by(6);
  flow_.edit(document);
  EXPECT_EQ(taken<CancelEvaluation>().size(), 1u) << "an edit that is not live does not wait";
}

// 5. States and failures

TEST_F(FlowTest, AFailedKeyIsNotTriedAgainUnlessAsked) {
  flow_.show("v");
  const Document first{{live("a"), shift("b", "a", 1)}, {{"v", {"b"}}}, {}};
  Document second = first;
  second.datasets[1].properties = by(2);
  flow_.edit(first);
  flow_.update("a", data(1, 1));
  EXPECT_EQ(started(), Names{"b"});
  flow_.failed(numbers_["b"], "it does not fit", 2);
  EXPECT_EQ(state("b").kind, State::Failed);
  EXPECT_EQ(state("b").text, "it does not fit");
  EXPECT_EQ(state("b").rank, 2);
  EXPECT_EQ(viewState("v").by, "b");
  flow_.edit(second);
  EXPECT_EQ(started(), Names{"b"});
  finish("b");
  EXPECT_EQ(state("b").kind, State::Done);
  flow_.edit(first);
  EXPECT_TRUE(started().empty());
  EXPECT_EQ(state("b").kind, State::Failed);
  EXPECT_TRUE(state("b").showsOlder) << "the last good output, marked";
  flow_.run("b");
  EXPECT_EQ(started(), Names{"b"});
}

TEST_F(FlowTest, OthersGoOnWhenANodeFailsAndNothingIsMixed) {
  flow_.show("v");
  flow_.edit({{live("a"), shift("b", "a", 1), shift("c", "a", 2), shift("d", "b")}, {{"v", {"c", "d"}}}, {}});
  flow_.update("a", data(1, 1));
  finishAll();
  flow_.update("a", data(1, 2));
  EXPECT_EQ(started(), (Names{"b", "c"}));
  flow_.failed(numbers_["b"], "no");
  EXPECT_EQ(state("d").kind, State::Blocked);
  EXPECT_EQ(state("d").by, "b");
  finish("c");
  const auto shown = taken<ShowData>();
  ASSERT_EQ(shown.size(), 1u);
  ASSERT_EQ(shown[0].data.size(), 1u) << "d is of another generation of a";
  EXPECT_EQ(shown[0].data[0].node, "c");
  ASSERT_EQ(shown[0].problems.size(), 1u);
  EXPECT_EQ(shown[0].problems[0].node, "b");
}

TEST_F(FlowTest, ACancelledNodeIsStaleAndNotTriedAgain) {
  flow_.show("v");
  flow_.edit({{live("a"), shift("b", "a")}, {{"v", {"b"}}}, {}});
  flow_.update("a", data(1, 1));
  EXPECT_EQ(started(), Names{"b"});
  flow_.cancel("b");
  EXPECT_EQ(taken<CancelEvaluation>().size(), 1u);
  flow_.cancelled(numbers_["b"]);
  EXPECT_TRUE(started().empty());
  EXPECT_EQ(state("b").kind, State::Stale);
  flow_.run();
  EXPECT_EQ(started(), Names{"b"});
}

TEST_F(FlowTest, AtMostTwoRunAndThoseBeingCancelledCount) {
  flow_.show("v");
  Document document{{live("a")}, {{"v", {}}}, {}};
  for (int i = 0; i < 4; i++) {
    document.datasets.push_back(shift("n" + std::to_string(i), "a", i));
    document.views[0].datasets.push_back("n" + std::to_string(i));
  }
  flow_.edit(document);
  flow_.update("a", data(1, 1));
  EXPECT_EQ(started(), (Names{"n0", "n1"}));
  EXPECT_EQ(state("n1").kind, State::Running);
  EXPECT_EQ(state("n2").kind, State::Queued);
  document.datasets[1].properties = by(9);
  flow_.edit(document);
  EXPECT_TRUE(started().empty());
  flow_.cancelled(numbers_["n0"]);
  EXPECT_EQ(started(), Names{"n0"});
}

TEST_F(FlowTest, ADatasetOfAnotherTypeFailsItsReaderAndNamesBoth) {
  flow_.show("v");
  flow_.edit({{live("a"), shift("b", "a")}, {{"v", {"b"}}}, {}});
  flow_.update("a", {{{1}, 1}, DatasetType::Particles, {}});
  EXPECT_TRUE(started().empty());
  EXPECT_EQ(state("b").kind, State::Failed);
  EXPECT_EQ(state("b").text, "input `field`: expected Volume, found \"a\", which is Particles");
}

TEST_F(FlowTest, ProgressIsTold) {
  flow_.show("v");
  flow_.edit({{live("a"), shift("b", "a")}, {{"v", {"b"}}}, {}});
  flow_.update("a", data(1, 1));
  started();
  flow_.progress(numbers_["b"], 3, 10, "tracing");
  const auto changes = taken<ChangeState>();
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].state.done, 3);
  EXPECT_EQ(changes[0].state.of, 10);
  EXPECT_EQ(changes[0].state.text, "tracing");
}

// 6. Memory

TEST_F(FlowTest, RoomIsMadeOfWhatNothingShowsOldestUseFirst) {
  flow_.show("v");
  Document document{{live("a"), shift("b", "a", 1)}, {{"v", {"b"}}}, {}};
  flow_.update("a", data(1, 1));
  std::vector<NodeKey> keys;
  for (int amount = 1; amount <= 3; amount++) {
    document.datasets[1].properties = by(amount);
    flow_.edit(document);
    const auto starts = taken<StartEvaluation>();
    ASSERT_EQ(starts.size(), 1u);
    keys.push_back(starts[0].key);
    flow_.finished(starts[0].evaluation, {1, 0.5, 100});
  }
  for (size_t i = 0; i < 2; i++) {
    EXPECT_TRUE(flow_.makeRoom());
    const auto drops = taken<DropOutput>();
    ASSERT_EQ(drops.size(), 1u);
    EXPECT_EQ(drops[0].key, keys[i]);
  }
  EXPECT_FALSE(flow_.makeRoom()) << "the third is shown";
  document.datasets[1].properties = by(1);
  flow_.edit(document);
  EXPECT_EQ(started(), Names{"b"}) << "made again on demand";
}

TEST_F(FlowTest, WhatIsMadeOfAnOutputThatIsGoneStays) {
  flow_.show("v");
  flow_.edit({{live("a"), shift("b", "a"), shift("c", "b")}, {{"v", {"c"}}}, {}});
  flow_.update("a", data(1, 1));
  finishAll();
  EXPECT_TRUE(flow_.makeRoom()) << "b";
  EXPECT_TRUE(started().empty());
  EXPECT_FALSE(flow_.makeRoom());
}

TEST_F(FlowTest, AViewWhoseOutputIsGoneKeepsItsPictureUntilItIsMadeAgain) {
  flow_.show("v");
  flow_.edit({{live("a"), shift("b", "a")}, {{"v", {"b"}}}, {}});
  flow_.update("a", data(1, 1));
  const auto starts = taken<StartEvaluation>();
  ASSERT_EQ(starts.size(), 1u);
  flow_.finished(starts[0].evaluation, {1, 0.5, 100});
  flow_.take();
  flow_.evicted(starts[0].key);
  EXPECT_EQ(started(), Names{"b"});
  EXPECT_EQ(among<HoldPicture>().size(), 1u);
  finish("b");
  EXPECT_EQ(taken<ShowData>().size(), 1u);
}

// 9. Edits are atomic

TEST_F(FlowTest, ARefusedEditChangesNothing) {
  flow_.show("v");
  const Document good{{live("a"), shift("b", "a")}, {{"v", {"b"}}}, {}};
  const uint64_t revision = flow_.edit(good);
  flow_.update("a", data(1, 1));
  EXPECT_EQ(started(), Names{"b"});
  Document bad = good;
  bad.datasets.push_back(shift("c", "c"));
  bad.datasets[1].properties = by(7);
  EXPECT_THROW(flow_.edit(bad), Error);
  EXPECT_EQ(flow_.revision(), revision);
  EXPECT_EQ(flow_.document().document(), good);
  EXPECT_TRUE(flow_.take().empty());
}

TEST_F(FlowTest, RemovingANodeLeavesItsConsumersIncomplete) {
  flow_.show("v");
  Document document{{live("a"), shift("b", "a"), shift("c", "b")}, {{"v", {"c"}}}, {}};
  flow_.edit(document);
  document.datasets.erase(document.datasets.begin() + 1);
  flow_.edit(document);
  EXPECT_EQ(state("c").kind, State::Incomplete);
  EXPECT_EQ(state("c").text, "input `field`: there is no dataset \"b\"");
  EXPECT_EQ(viewState("v").by, "c");
}

TEST_F(FlowTest, AnUnknownNodeIsAnError) {
  EXPECT_THROW(flow_.run("nobody"), Error);
  EXPECT_THROW(flow_.cancel("nobody"), Error);
}

}  // namespace
}  // namespace gxy::flow
