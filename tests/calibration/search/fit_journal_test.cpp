// Searches that are interrupted and go on: the shipped load cell, which lacks an effect.
#include "kinetostat/calibration/search/fit_journal.h"

#include <cstdint>
#include <cstring>
#include <map>
#include <mutex>
#include <set>
#include <thread>

#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/diagnosis/diagnosis.h"
#include "kinetostat/calibration/regression/campaign_noise.h"
#include "kinetostat/calibration/search/fit_record.h"
#include "kinetostat/common/error.h"
#include "kinetostat/report/diagnosis_file.h"

namespace kinetostat::calibration::fit_journal_test {
namespace {

// In memory; asks for the search to be stopped when it has kept so much more.
class Memory : public FitJournal {
 public:
  std::optional<std::string> find(const std::string& key) override {
    const auto it = entries.find(key);
    if (it == entries.end()) return std::nullopt;
    ++found;
    return it->second;
  }
  void keep(const std::string& key, const std::string& content) override {
    entries[key] = content;
    ++computed;
  }

  std::map<std::string, std::string> entries;
  int found = 0, computed = 0, most = 1 << 30;
};

class StopsWith : public common::Progress {
 public:
  explicit StopsWith(const Memory& memory) : memory_(memory) {}
  bool cancelled() const override { return memory_.computed >= memory_.most; }

 private:
  const Memory& memory_;
};

class FitJournalTest : public testing::Test {
 protected:
  std::string diagnosed(Memory* memory, int threads = 1) const {
    const Memory none;
    StopsWith progress(memory == nullptr ? none : *memory);
    const DiagnosisOptions options{.kinds = {}, .draws = 99, .profiles = 2, .journal = memory};
    return report::to_json(robot_, campaign_,
                           diagnose(robot_, campaign_, options, threads, progress))
        .dump();
  }

  common::Progress silent_;
  vjm::Robot robot_ =
      vjm::read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/bench.yaml");
  Campaign campaign_ = read_campaign(
      std::string(KINETOSTAT_SOURCE_DIR) + "/data/measurements/nist_load_cell/campaign.yaml",
      robot_.manipulator);
};

TEST_F(FitJournalTest, StoppedAfterEveryOtherStepItGoesOnAndEndsWithTheSameBytes) {
  const std::string never_stopped = diagnosed(nullptr);
  Memory whole;
  EXPECT_EQ(diagnosed(&whole), never_stopped);
  EXPECT_EQ(whole.found, 0);
  ASSERT_GT(whole.computed, 40);
  for (int k = 1; k < whole.computed; k += 2) {
    Memory memory;
    memory.most = k;
    EXPECT_THROW((void)diagnosed(&memory), common::Cancelled) << k;
    const int before = memory.computed;
    EXPECT_GE(before, k);
    memory.most = 1 << 30;
    EXPECT_EQ(diagnosed(&memory), never_stopped) << k;
    EXPECT_EQ(memory.found, before);
    EXPECT_EQ(memory.computed, whole.computed) << "nothing is computed twice";
  }
}

// Asks for the search to be stopped when it starts a fit, or signatures.
class StoppedAtBeginning : public Memory {
 public:
  explicit StoppedAtBeginning(int of) : of_(of) {}
  std::optional<std::string> find(const std::string& key) override {
    if (++begun_ == of_) most = 0;
    return Memory::find(key);
  }

 private:
  int of_, begun_ = 0;
};

TEST_F(FitJournalTest, NobodyWaitsForTheEndOfAFit) {
  for (const int k : {1, 2, 10, 20, 30, 40}) {
    StoppedAtBeginning memory(k);
    EXPECT_THROW((void)diagnosed(&memory), common::Cancelled);
    EXPECT_EQ(memory.computed, k - 1);
  }
}

TEST_F(FitJournalTest, NoNumberOfThreadsMatters) {
  Memory memory;
  memory.most = 20;
  EXPECT_THROW((void)diagnosed(&memory, 2), common::Cancelled);
  memory.most = 1 << 30;
  EXPECT_EQ(diagnosed(&memory, 1), diagnosed(nullptr, 2));
  EXPECT_GE(memory.found, 20);
  const int computed = memory.computed;
  EXPECT_EQ(diagnosed(&memory, 3), diagnosed(nullptr));
  EXPECT_EQ(memory.computed, computed) << "all of it was there";
}

// For several workers at once, each of which claims what it works on.
class Shared : public Memory {
 public:
  std::optional<std::string> find(const std::string& key) override {
    const std::lock_guard lock(mutex_);
    return Memory::find(key);
  }
  void keep(const std::string& key, const std::string& content) override {
    const std::lock_guard lock(mutex_);
    twice += entries.contains(key) ? 1 : 0;
    Memory::keep(key, content);
  }
  bool claim(const std::string& item) override {
    const std::lock_guard lock(mutex_);
    const bool is_free = claimed.insert(item).second;
    refused += is_free ? 0 : 1;
    return is_free;
  }
  void give_up(const std::string& item) override {
    const std::lock_guard lock(mutex_);
    claimed.erase(item);
  }

  std::set<std::string> claimed;
  int refused = 0, twice = 0;

 private:
  std::mutex mutex_;
};

TEST_F(FitJournalTest, WorkersShareOneSearchAndEachHasAllOfIt) {
  Memory alone;
  const std::string expected = diagnosed(&alone);
  Shared shared;
  std::vector<std::string> results(3);
  std::vector<std::thread> workers;
  for (std::string& result : results) workers.emplace_back([&] { result = diagnosed(&shared, 2); });
  for (std::thread& worker : workers) worker.join();
  for (const std::string& result : results) EXPECT_EQ(result, expected);
  EXPECT_GT(shared.refused, 0) << "they are there at the same time";
  EXPECT_EQ(shared.twice, 0);
  EXPECT_EQ(shared.computed, alone.computed);
  EXPECT_TRUE(shared.claimed.empty());
}

// Somebody else works on each item when it is asked for first, and is gone the next time.
class Busy : public Memory {
 public:
  bool claim(const std::string& item) override { return !seen_.insert(item).second; }

 private:
  std::set<std::string> seen_;
};

TEST_F(FitJournalTest, ItDoesWhatOthersHaveLeftUndone) {
  Busy busy;
  EXPECT_EQ(diagnosed(&busy), diagnosed(nullptr));
  EXPECT_GT(busy.computed, 40);
}

// Somebody else works on an item and does not come to an end; the user stops waiting.
class Stuck : public Memory {
 public:
  explicit Stuck(bool (*is_held)(const std::string&)) : is_held_(is_held) {}
  bool claim(const std::string& item) override {
    if (!is_held_(item)) return true;
    most = ++refused < 5 ? most : 0;
    return false;
  }

  int refused = 0;

 private:
  bool (*is_held_)(const std::string&);
};

TEST_F(FitJournalTest, WaitingCanBeStopped) {
  Stuck fit([](const std::string&) { return true; });
  EXPECT_THROW((void)diagnosed(&fit), common::Cancelled);
  EXPECT_EQ(fit.computed, 0);
  Stuck item([](const std::string& name) { return name.starts_with("screening of load_hard"); });
  EXPECT_THROW((void)diagnosed(&item), common::Cancelled);
  EXPECT_GT(item.computed, 3) << "all other candidates come first";
}

// The journal of the program finds nothing that is damaged; if one does, that is no answer.
TEST_F(FitJournalTest, RecordsThatAreNoneAreComputedAnew) {
  Memory memory;
  const std::string right = diagnosed(&memory);
  const int computed = memory.computed;
  int turn = 0;
  for (auto& [key, content] : memory.entries) {
    if (turn % 3 == 0) content.resize(content.size() / 2);
    if (turn % 3 == 1) content += "more";
    if (turn++ % 3 == 2) content.clear();
  }
  EXPECT_EQ(diagnosed(&memory), right);
  EXPECT_EQ(memory.computed, 2 * computed);
}

// Sizes of lists and matrices among them, also of those that can have one size only.
TEST(FitRecord, NumbersOfAnySizeAreNoRecord) {
  BaseFit fit;
  fit.predicted.resize(2, spatial::Vector6::Ones());
  fit.weak = {"a"};
  const std::string sound = record_of(fit);
  for (std::size_t at = 0; at + sizeof(std::int64_t) <= sound.size(); ++at)
    for (const std::int64_t number :
         {std::int64_t{7}, std::int64_t{1} << 31, std::int64_t{1} << 61, std::int64_t{-1}}) {
      std::string other = sound;
      std::memcpy(other.data() + at, &number, sizeof number);
      EXPECT_NO_THROW((void)recorded_fit(other, {})) << at << " " << number;
    }
}

TEST_F(FitJournalTest, RecordsHoldEveryBit) {
  const Noise noise = noise_of(robot_, campaign_, 1, silent_);
  const CandidateFitter fitter(robot_, campaign_, noise, 1, silent_);
  const BaseFit base = fitter.fit({}, nullptr, silent_);
  const std::vector<Candidate> added = {candidates(robot_, {"load_hardening"}).front()};
  const BaseFit fit = fitter.fit(added, &base, silent_);
  std::vector<Parameter> unknowns;
  for (const ParameterEstimate& estimate : fit.parameters) unknowns.push_back(estimate.parameter);
  const std::optional<BaseFit> back = recorded_fit(record_of(fit), unknowns);
  ASSERT_TRUE(back);
  EXPECT_EQ(record_of(*back), record_of(fit));
  EXPECT_EQ(values_of(*back), values_of(fit));
  EXPECT_EQ(back->at.jacobian, fit.at.jacobian);
  EXPECT_EQ(back->parameters[0].parameter.phrase(), fit.parameters[0].parameter.phrase());
  EXPECT_FALSE(recorded_fit(record_of(fit), {})) << "of other parameters";

  const CandidateFitter::Signatures signatures = fitter.signatures_of(added[0], {}, base, silent_);
  const std::optional<CandidateFitter::Signatures> signatures_back =
      recorded_signatures(record_of(signatures), added[0]);
  ASSERT_TRUE(signatures_back);
  EXPECT_EQ(record_of(*signatures_back), record_of(signatures));
  EXPECT_EQ(signatures_back->all[0].columns, signatures.all[0].columns);
  EXPECT_EQ(signatures_back->starts[0].name(), added[0].name());
  EXPECT_FALSE(recorded_signatures(record_of(fit), added[0]));
  EXPECT_FALSE(recorded_fit(record_of(signatures), unknowns));

  const CondensedFit rough{values_of(fit), 12.5};
  const auto rough_back = recorded_condensed_fit(record_of(std::optional(rough)), unknowns);
  ASSERT_TRUE(rough_back && *rough_back);
  EXPECT_EQ((*rough_back)->values, rough.values);
  EXPECT_EQ((*rough_back)->cost, rough.cost);
  const auto none = recorded_condensed_fit(record_of(std::optional<CondensedFit>()), unknowns);
  EXPECT_TRUE(none && !*none);
  EXPECT_FALSE(recorded_condensed_fit(record_of(std::optional(rough)), {})) << "of others";
  EXPECT_FALSE(recorded_condensed_fit(record_of(fit), unknowns));
}

TEST_F(FitJournalTest, KnowsWhatReadingsCannotDetermine) {
  try {
    (void)recorded_fit(record_of(common::NotIdentifiable("no reading depends on it")), {});
    ADD_FAILURE() << "it must throw";
  } catch (const common::NotIdentifiable& failure) {
    EXPECT_STREQ(failure.what(), "no reading depends on it");
  }
}

// Everything that a fit is made of is asked for.
TEST_F(FitJournalTest, OtherQuestionsHaveOtherKeys) {
  const Noise noise = noise_of(robot_, campaign_, 1, silent_);
  const std::string scope = fit_scope(campaign_, noise);
  Campaign masked = campaign_;
  masked.readings[3].masked = true;
  EXPECT_NE(fit_scope(masked, noise), scope);
  Noise larger = noise;
  larger.sigma[5][2] *= 1 + 1e-15;
  EXPECT_NE(fit_scope(campaign_, larger), scope);

  const CandidateFitter fitter(robot_, campaign_, noise, 1, silent_);
  const BaseFit base = fitter.fit({}, nullptr, silent_);
  std::vector<vjm::Effect> effects = {candidates(robot_, {"clearance"}).front().effect};
  const std::vector<Parameter> unknowns = {base.parameters[0].parameter};
  const auto key_with = [&](const auto& change) {
    std::vector<Parameter> changed = unknowns;
    change(changed[0]);
    return fit_key(scope, effects, changed, &base.model, 0);
  };
  std::vector<std::string> keys = {fit_key(scope, effects, unknowns, &base.model, 0),
                                   fit_key(scope, effects, unknowns, &base.model, 1),
                                   fit_key(scope, effects, unknowns, nullptr, 0),
                                   fit_key(scope, {}, unknowns, &base.model, 0),
                                   fit_key("", effects, unknowns, &base.model, 0)};
  keys.push_back(key_with([](Parameter& p) { p.start += 1e-9; }));
  keys.push_back(key_with([](Parameter& p) { p.lower /= 2; }));
  keys.push_back(key_with([](Parameter& p) { p.upper /= 2; }));
  keys.push_back(key_with([](Parameter& p) { p.bounds_stated = !p.bounds_stated; }));
  keys.push_back(key_with([](Parameter& p) { p.prior = {0, 1, 0}; }));
  keys.push_back(key_with([](Parameter& p) { p.prior = {0, 2, 0}; }));
  effects[0].values[0] *= 2;
  keys.push_back(fit_key(scope, effects, unknowns, &base.model, 0));
  effects[0].at = "elsewhere";
  keys.push_back(fit_key(scope, effects, unknowns, &base.model, 0));
  Predictions elsewhere = base.model;
  elsewhere.loaded.front().coordinates.front()[0] += 1e-12;
  keys.push_back(fit_key(scope, effects, unknowns, &elsewhere, 0));

  const Candidate candidate = candidates(robot_, {"clearance"}).front();
  BaseFit moved = base;
  moved.parameters[0].value += 1e-12;
  keys.push_back(signatures_key(scope, candidate, fitted_key({}, base)));
  keys.push_back(signatures_key(scope, candidate, fitted_key({}, moved)));
  keys.push_back(signatures_key(scope, candidate, fitted_key({candidate}, base)));
  Candidate wider = candidate;
  wider.deviations[0] *= 2;
  keys.push_back(signatures_key(scope, wider, fitted_key({}, base)));
  for (std::size_t i = 0; i < keys.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(keys[i], keys[j]) << i << " and " << j;
}

}  // namespace
}  // namespace kinetostat::calibration::fit_journal_test
