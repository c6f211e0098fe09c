#include <consimd/studies/shard.hpp>

#include <map>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace consimd::studies {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

using Variables = std::map<std::string, std::string>;

Shard shard_in(const Variables& variables, std::string_view launcher = "auto") {
  return shard_from_environment(launcher, [&](const char* name) {
    const auto found = variables.find(name);
    return found == variables.end() ? nullptr : found->second.c_str();
  });
}

template <typename... Texts>
void expect_refused(const Variables& variables, std::string_view launcher, const Texts&... texts) {
  EXPECT_THAT([&] { (void)shard_in(variables, launcher); },
              ThrowsMessage<std::invalid_argument>(AllOf(HasSubstr(texts)...)));
}

TEST(Shard, DealsEverythingOutOnce) {
  for (const std::uint32_t count : {1u, 3u, 7u, 100u}) {
    std::vector<int> owners(50, 0);
    for (std::uint32_t index = 1; index <= count; ++index) {
      for (std::size_t item = 0; item < owners.size(); ++item) owners[item] += Shard{index, count}.owns(item);
    }
    EXPECT_THAT(owners, testing::Each(1)) << count;
  }
}

TEST(Shard, ReadsBackFromItsText) {
  const Shard shard{.index = 2, .count = 16};
  EXPECT_EQ(to_string(shard), "2/16");
  EXPECT_EQ(parse_shard("2/16"), shard);
  EXPECT_EQ(folder_name(shard), "shard-2-of-16");
  for (const char* bad : {"", "/", "1", "1/", "/1", "0/4", "5/4", "-1/4", "1/0", "1/4/2", "a/b", "1.0/4", " 1/4",
                          "1/4 ", "+1/4", "1/1000001", "1/99999999999"}) {
    EXPECT_THROW((void)parse_shard(bad), std::invalid_argument) << bad;
  }
}

TEST(ShardFromEnvironment, TakesTheRankOfEveryLauncher) {
  const Shard third{.index = 3, .count = 4};
  for (const Launcher& launcher : launchers()) {
    const Variables variables{{std::string(launcher.rank), "2"}, {std::string(launcher.count), "4"}};
    EXPECT_EQ(shard_in(variables), third) << launcher.name;
    EXPECT_EQ(shard_in(variables, launcher.name), third) << launcher.name;
  }
}

TEST(ShardFromEnvironment, CountsArrayIndicesFromTheFirstInSteps) {
  const auto task = [](const char* id, const char* count, const char* min, const char* max, const char* step) {
    return Variables{{"SLURM_ARRAY_TASK_ID", id},
                     {"SLURM_ARRAY_TASK_COUNT", count},
                     {"SLURM_ARRAY_TASK_MIN", min},
                     {"SLURM_ARRAY_TASK_MAX", max},
                     {"SLURM_ARRAY_TASK_STEP", step}};
  };
  EXPECT_EQ(shard_in(task("1", "4", "1", "4", "1")), (Shard{1, 4}));
  EXPECT_EQ(shard_in(task("4", "4", "1", "4", "1")), (Shard{4, 4}));
  EXPECT_EQ(shard_in(task("0", "4", "0", "3", "1")), (Shard{1, 4}));
  EXPECT_EQ(shard_in(task("110", "3", "100", "110", "5")), (Shard{3, 3}));
  // --array=1,2,4: all tasks refuse, not the last alone, which would leave the others to run a part each.
  for (const char* id : {"1", "2", "4"}) {
    expect_refused(task(id, "3", "1", "4", "1"), "auto", "SLURM_ARRAY_TASK_ID", "evenly spaced", "K/N");
  }
  expect_refused(task("103", "3", "100", "110", "5"), "auto", "SLURM_ARRAY_TASK_ID 103");
  expect_refused(task("0", "4", "1", "4", "1"), "auto", "SLURM_ARRAY_TASK_MIN 1");
}

TEST(ShardFromEnvironment, PrefersRanksToTheStepThatStartedThem) {
  // mpirun in a Slurm job: its processes inherit the variables of the batch step, or of its daemons.
  const Variables mpi{
      {"SLURM_PROCID", "0"}, {"SLURM_NTASKS", "2"}, {"OMPI_COMM_WORLD_RANK", "3"}, {"OMPI_COMM_WORLD_SIZE", "8"}};
  EXPECT_EQ(shard_in(mpi), (Shard{4, 8}));
  EXPECT_EQ(shard_in(mpi, "slurm"), (Shard{1, 2}));
  // An array of jobs of one task each.
  const Variables array{
      {"SLURM_PROCID", "0"}, {"SLURM_NTASKS", "1"}, {"SLURM_ARRAY_TASK_ID", "7"}, {"SLURM_ARRAY_TASK_COUNT", "8"}};
  EXPECT_EQ(shard_in(array), (Shard{8, 8}));
  EXPECT_EQ(shard_in({{"PMI_RANK", "0"}, {"PMI_SIZE", "1"}}), (Shard{1, 1}));
}

TEST(ShardFromEnvironment, RefusesToChoose) {
  const Variables both{{"OMPI_COMM_WORLD_RANK", "1"},
                       {"OMPI_COMM_WORLD_SIZE", "2"},
                       {"SLURM_ARRAY_TASK_ID", "1"},
                       {"SLURM_ARRAY_TASK_COUNT", "4"},
                       {"SLURM_ARRAY_TASK_MIN", "1"}};
  expect_refused(both, "auto", "slurm-array says 1/4 (SLURM_ARRAY_TASK_ID)", "openmpi says 2/2");
  EXPECT_EQ(shard_in(both, "openmpi"), (Shard{2, 2}));
  EXPECT_EQ(shard_in(both, "slurm-array"), (Shard{1, 4}));
  Variables agree = both;
  agree["SLURM_ARRAY_TASK_ID"] = agree["SLURM_ARRAY_TASK_COUNT"] = "2";
  EXPECT_EQ(shard_in(agree), (Shard{2, 2}));
}

TEST(ShardFromEnvironment, NamesWhatIsMissingOrWrong) {
  expect_refused({}, "auto", "names no part", "slurm-array: no SLURM_ARRAY_TASK_ID and SLURM_ARRAY_TASK_COUNT",
                 "pmi: no PMI_RANK and PMI_SIZE");
  expect_refused({{"PMI_RANK", "1"}}, "auto", "pmi: no PMI_SIZE");
  expect_refused({{"PMI_RANK", "1"}, {"PMI_SIZE", "2"}}, "openmpi", "openmpi: no OMPI_COMM_WORLD_RANK");
  expect_refused({{"PMI_RANK", "2"}, {"PMI_SIZE", "2"}}, "auto", "PMI_RANK 2 is no rank among PMI_SIZE 2");
  expect_refused({{"PMI_RANK", "0"}, {"PMI_SIZE", "0"}}, "auto", "PMI_SIZE 0");
  expect_refused({{"PMI_RANK", "-1"}, {"PMI_SIZE", "2"}}, "auto", "PMI_RANK: '-1' is not a whole number");
  expect_refused({{"PMI_RANK", "0"}, {"PMI_SIZE", ""}}, "auto", "PMI_SIZE: '' is not a whole number");
  expect_refused({}, "", "expected K/N, auto, slurm-array, openmpi, pmi, slurm, got ''");
  expect_refused({}, "3", "got '3'");
}

}  // namespace
}  // namespace consimd::studies
