#include <consimd/studies/value_list.hpp>

#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace consimd::studies {
namespace {

using testing::ElementsAre;

TEST(ValueList, TakesAListAsIs) {
  EXPECT_THAT(parse_value_list("0.1,0.5,2e1"), ElementsAre(0.1, 0.5, 20.0));
  EXPECT_THAT(parse_value_list("3"), ElementsAre(3.0));
}

TEST(ValueList, SpacesEvenlyWithBothEnds) {
  EXPECT_THAT(parse_value_list("1:2:3"), ElementsAre(1.0, 1.5, 2.0));
  EXPECT_THAT(parse_value_list("-1:1:2"), ElementsAre(-1.0, 1.0));
}

TEST(ValueList, SpacedValuesAreTheDecimalsThatPeopleMean) {
  const std::vector<double> sigmas = parse_value_list("0.1:5:50");
  ASSERT_EQ(sigmas.size(), 50u);
  EXPECT_EQ(sigmas[0], 0.1);
  EXPECT_EQ(sigmas[2], 0.3);
  EXPECT_EQ(sigmas[48], 4.9);
  EXPECT_EQ(sigmas[49], 5.0);
}

TEST(ValueList, RefusesWhatIsNoList) {
  for (const char* text :
       {"",      ",",       "1,",      ",1",           "1,,2",  "a",     "1 ",     "nan",     "inf",
        "1e999", "1:2",     "1:2:3:4", "1:2:x",        "1:2:0", "1:2:1", "1:2:-3", "1:2:2.5", "2:1:5",
        "1:1:5", "1:nan:5", ":2:5",    "1:2:999999999"}) {
    EXPECT_THROW((void)parse_value_list(text), std::invalid_argument) << "'" << text << "'";
  }
}

}  // namespace
}  // namespace consimd::studies
