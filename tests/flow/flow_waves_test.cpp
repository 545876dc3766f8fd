// SPDX-License-Identifier: Apache-2.0
// What a graph promises of waves and of data that it adopts, one sentence at a time.
#include "tests/flow/flow_fixture.h"

namespace gxy::flow {
namespace {

// 3. Waves

TEST_F(FlowTest, AWaveTakesOneStepOfAllSourcesOfAPublisher) {
  flow_.show("v");
  flow_.edit({{live("a"), live("b"), sum("c", {"a", "b"})}, {{"v", {"c"}}}, {}});
  flow_.update("a", step(1, 1, 12));
  flow_.update("b", step(2, 1, 11));
  EXPECT_TRUE(started().empty());
  EXPECT_EQ(viewState("v").text, "\"b\" is of step 11 and \"a\" of step 12 of the same publisher");
  flow_.update("b", step(2, 2, 12));
  EXPECT_EQ(started(), Names{"c"});
}

TEST_F(FlowTest, AStepThatIsNotCompleteDoesNotReplaceOneThatIsHeld) {
  flow_.show("v");
  flow_.edit({{live("a"), live("b"), sum("c", {"a", "b"})}, {{"v", {"a", "b"}}}, {}});
  flow_.update(std::vector<Flow::Update>{{"a", step(1, 1, 12)}, {"b", step(2, 1, 12)}});
  flow_.take();
  flow_.update("a", step(1, 2, 13));
  Document more{flow_.document().document()};
  more.views[0].datasets.push_back("c");
  flow_.edit(more);
  const auto starts = taken<StartEvaluation>();
  ASSERT_EQ(starts.size(), 1u);
  EXPECT_EQ(starts[0].inputs[0].items[0].data, DataId(SourceGeneration{{1}, 1}))
      << "that of step 12, which is held";
}

TEST_F(FlowTest, NewDataWaitForTheWaveAndTheNewestWin) {
  flow_.show("v");
  flow_.edit({{live("a"), shift("b", "a"), shift("c", "b")}, {{"v", {"c"}}}, {}});
  flow_.update("a", data(1, 1));
  EXPECT_EQ(started(), Names{"b"});
  for (Generation generation = 2; generation <= 5; generation++) flow_.update("a", data(1, generation));
  EXPECT_TRUE(taken<CancelEvaluation>().empty());
  finish("b");
  EXPECT_EQ(started(), Names{"c"});
  finish("c");
  const auto starts = taken<StartEvaluation>();
  EXPECT_EQ(among<ShowData>().size(), 1u) << "of the first generation";
  ASSERT_EQ(starts.size(), 1u);
  EXPECT_EQ(starts[0].inputs[0].items[0].data, DataId(SourceGeneration{{1}, 5}));
  EXPECT_EQ(state("a").leftOut, 3u);
}

TEST_F(FlowTest, AViewChangesAtOnceWhenAllThatItShowsIsThere) {
  flow_.show("v");
  flow_.show("w");
  flow_.edit({{live("a"), shift("b", "a", 1), shift("c", "a", 2)},
              {{"v", {"a", "b", "c"}}, {"w", {"a", "b", "c"}, true, true}},
              {}});
  flow_.update("a", data(1, 1));
  EXPECT_EQ(started(), (Names{"b", "c"}));
  EXPECT_EQ(among<ShowData>().size(), 1u) << "the source, as it comes";
  finish("b");
  auto shown = taken<ShowData>();
  ASSERT_EQ(shown.size(), 1u);
  EXPECT_EQ(shown[0].target.name, "w");
  EXPECT_EQ(shown[0].data.size(), 2u);
  finish("c");
  shown = taken<ShowData>();
  ASSERT_EQ(shown.size(), 2u);
  EXPECT_EQ(shown[0].data.size(), 3u);
}

TEST_F(FlowTest, AGenerationThatIsWantedAndNeededIsAdopted) {
  flow_.show("v");
  flow_.edit({{live("a")}, {{"v", {"a"}, false}}, {}});
  flow_.update("a", data(1, 1));
  const auto pins = taken<PinGeneration>();
  ASSERT_EQ(pins.size(), 1u);
  flow_.update("a", data(1, 2));
  flow_.tick(100);
  EXPECT_TRUE(taken<AdoptGeneration>().empty()) << "nobody wants it";
  flow_.wanted({{1}, 1});
  flow_.tick(9);
  EXPECT_TRUE(taken<AdoptGeneration>().empty());
  flow_.tick(1);
  const auto adoptions = taken<AdoptGeneration>();
  ASSERT_EQ(adoptions.size(), 1u);
  EXPECT_EQ(adoptions[0].hold, pins[0].hold);
  flow_.adopted(pins[0].hold);
  flow_.tick(100);
  flow_.dropped("a");
  EXPECT_TRUE(taken<ReleaseGeneration>().empty()) << "the drop of its name does not touch it";
  flow_.hide("v");
  EXPECT_EQ(taken<ReleaseGeneration>().size(), 1u);
}

TEST_F(FlowTest, ARefusedAdoptionLeavesThePictureUntilTheNextWave) {
  flow_.show("v");
  flow_.edit({{live("a"), shift("b", "a")}, {{"v", {"a", "b"}}}, {}});
  flow_.update("a", data(1, 1));
  finishAll();
  flow_.update("a", data(1, 2));
  EXPECT_EQ(started(), Names{"b"});
  flow_.wanted({{1}, 1});
  flow_.tick(10);
  const auto adoptions = taken<AdoptGeneration>();
  ASSERT_EQ(adoptions.size(), 1u);
  flow_.refused(adoptions[0].hold, "5 MiB are missing");
  ASSERT_EQ(taken<HoldPicture>().size(), 1u);
  EXPECT_EQ(among<ReleaseGeneration>().size(), 1u);
  EXPECT_TRUE(among<CancelEvaluation>().empty());
  finish("b");
  EXPECT_EQ(taken<ShowData>().size(), 1u);
}

TEST_F(FlowTest, ARefusedAdoptionLetsTheWaveGoOn) {
  flow_.show("v");
  flow_.edit({{live("a"), shift("b", "a"), sum("c", {"a", "b"})}, {{"v", {"c"}}}, {}});
  flow_.update("a", data(1, 1));
  EXPECT_EQ(started(), Names{"b"});
  flow_.update("a", data(1, 2));
  flow_.wanted({{1}, 1});
  flow_.tick(10);
  const auto adoptions = taken<AdoptGeneration>();
  ASSERT_EQ(adoptions.size(), 1u);
  flow_.refused(adoptions[0].hold, "no room");
  EXPECT_TRUE(taken<ReleaseGeneration>().empty());
  finish("b");
  EXPECT_EQ(started(), Names{"c"});
  flow_.tick(10);
  EXPECT_EQ(taken<AdoptGeneration>().size(), 1u) << "asked again";
}

TEST_F(FlowTest, WhatOnlyACancelledEvaluationReadsIsHeldButNotAdopted) {
  flow_.show("v");
  flow_.edit({{live("a"), shift("b", "a")}, {{"v", {"b"}}}, {}});
  flow_.update("a", data(1, 1));
  EXPECT_EQ(started(), Names{"b"});
  flow_.hide("v");
  flow_.wanted({{1}, 1});
  flow_.tick(100);
  EXPECT_TRUE(taken<ReleaseGeneration>().empty());
  EXPECT_TRUE(among<AdoptGeneration>().empty());
  flow_.cancelled(numbers_["b"]);
  EXPECT_EQ(taken<ReleaseGeneration>().size(), 1u);
}

TEST_F(FlowTest, AViewThatNoWindowFollowsTakesNoNewerDataButEdits) {
  flow_.show("v");
  flow_.edit({{live("a"), shift("b", "a")}, {{"v", {"b"}}}, {}});
  flow_.update("a", data(1, 1));
  finishAll();
  flow_.show("v", false);
  flow_.update("a", data(1, 2));
  EXPECT_EQ(started(), Names{});
  EXPECT_FALSE(flow_.isBusy());
  flow_.edit({{live("a"), shift("b", "a", 2)}, {{"v", {"b"}}}, {}});
  finishAll();
  flow_.update("a", data(1, 3));
  EXPECT_EQ(started(), Names{});
  flow_.show("v");
  EXPECT_EQ(started(), Names{"b"});
}

TEST_F(FlowTest, AViewThatWaitsForItsStepIsNotPassedOver) {
  flow_.show("v");
  flow_.show("w");
  Document document{
      {live("a"), live("b"), shift("d", "a"), sum("c", {"a", "b"})}, {{"v", {"d"}}, {"w", {"a", "b"}}}, {}};
  flow_.edit(document);
  flow_.update(std::vector<Flow::Update>{{"a", step(1, 1, 12)}, {"b", step(2, 1, 12)}});
  finishAll();
  flow_.update("a", step(1, 2, 13));
  const auto starts = taken<StartEvaluation>();
  ASSERT_EQ(starts.size(), 1u);
  EXPECT_EQ(starts[0].node, "d");
  document.views[1].datasets.push_back("c");
  flow_.edit(document);
  EXPECT_EQ(viewState("w").text, "for the wave that runs") << "it needs step 12, and the wave is of step 13";
  flow_.update("a", step(1, 3, 14));
  flow_.finished(starts[0].evaluation, {1, 0.5, 100});
  EXPECT_EQ(started(), Names{"c"}) << "not d again";
  const auto shown = among<ShowData>();
  ASSERT_EQ(shown.size(), 1u);
  EXPECT_EQ(shown[0].data.at(0).data, DataId(starts[0].key)) << "of step 13: v is not in the wave of step 12";
  finish("c");
  EXPECT_EQ(started(), Names{"d"});
}

TEST_F(FlowTest, AGenerationThatIsGoneIsNotWaitedFor) {
  flow_.show("v");
  flow_.edit({{live("a"), shift("b", "a")}, {{"v", {"b"}}}, {}});
  flow_.update("a", data(1, 1));
  EXPECT_EQ(started(), Names{"b"});
  flow_.lost({{1}, 1});
  EXPECT_EQ(taken<CancelEvaluation>().size(), 1u);
  flow_.cancelled(numbers_["b"]);
  flow_.update("a", data(1, 2));
  EXPECT_EQ(started(), Names{"b"});
}

}  // namespace
}  // namespace gxy::flow
