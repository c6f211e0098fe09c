#include <consimd/features/cloud_verdict.hpp>

#include <gtest/gtest.h>

namespace consimd::test {
namespace {

features::PoseEvidence borne_out() {
  features::PoseEvidence evidence;
  evidence.samples = 640;
  evidence.agreement = evidence.fitted_agreement = 0.5;
  evidence.displaced_agreement = 0.1;
  evidence.displaced_seen_through = 0.1;
  evidence.log10_chance = -6.0;
  return evidence;
}

TEST(BorneOut, AsksForBothChances) {
  const features::PoseEvidence evidence = borne_out();
  EXPECT_TRUE(is_borne_out(evidence, -2.1));
  EXPECT_FALSE(is_borne_out(evidence, -1.9));
  features::PoseEvidence common = evidence;
  common.log10_chance = -2.4;
  EXPECT_FALSE(is_borne_out(common, -300.0));
}

TEST(BorneOut, DisplacedPosesThatMeetNothingTellLittleOfChance) {
  // An object in empty space: nearly any other pose misses it.
  features::PoseEvidence evidence = borne_out();
  evidence.displaced_agreement = 0.01;
  evidence.log10_chance = -20.0;
  EXPECT_FALSE(is_borne_out(evidence, -3.9));
  EXPECT_TRUE(is_borne_out(evidence, -4.1));
  evidence.log10_chance = -3.0;
  EXPECT_FALSE(is_borne_out(evidence, -4.9));
  EXPECT_TRUE(is_borne_out(evidence, -5.1));
}

TEST(BorneOut, APoseThatIsSeenThroughIsNone) {
  features::PoseEvidence evidence = borne_out();
  evidence.seen_through = 0.04;
  EXPECT_TRUE(is_borne_out(evidence, -10.0));
  evidence.seen_through = 0.06;
  EXPECT_FALSE(is_borne_out(evidence, -10.0));
  evidence = borne_out();
  evidence.fitted_seen_through = 0.03;
  EXPECT_FALSE(is_borne_out(evidence, -10.0));
}

TEST(BorneOut, ARivalIsEqualUnlessItIsSeenThroughMore) {
  features::PoseEvidence evidence = borne_out();
  EXPECT_FALSE(has_equal_rival(evidence));
  evidence.rival.emplace();
  evidence.rival->share_of_score = 0.85;
  evidence.rival->agreement = 0.4;
  EXPECT_TRUE(has_equal_rival(evidence));
  evidence.rival->seen_through = 0.1;
  EXPECT_FALSE(has_equal_rival(evidence));
  evidence.seen_through = 0.07;  // the pose does not rule it out by what it has itself
  EXPECT_TRUE(has_equal_rival(evidence));
  evidence.rival->share_of_score = 0.45;
  EXPECT_FALSE(has_equal_rival(evidence));
}

TEST(BorneOut, ARivalOfFourFifthsIsInDoubtUnlessItIsSeenThrough) {
  features::PoseEvidence evidence = borne_out();
  EXPECT_FALSE(has_rival_in_doubt(evidence));
  evidence.rival.emplace();
  evidence.rival->share_of_score = 0.81;
  evidence.rival->agreement = 0.4;
  evidence.rival->seen_through = 0.04;  // more than would make it an equal one
  EXPECT_TRUE(has_rival_in_doubt(evidence));
  EXPECT_FALSE(has_equal_rival(evidence));
  evidence.rival->seen_through = 0.05;
  EXPECT_FALSE(has_rival_in_doubt(evidence));
  evidence.rival->seen_through = 0.04;
  evidence.rival->share_of_score = 0.79;
  EXPECT_FALSE(has_rival_in_doubt(evidence));
}

}  // namespace
}  // namespace consimd::test
