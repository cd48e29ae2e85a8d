#include "engine/app/cases/next_case.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/keys.h"
#include "engine/base/sha256.h"
#include "engine/base/split_mix.h"

namespace typodont {

namespace {

// A family trains a skill that has at least this fraction of its points.
constexpr double kLeastTrained = 0.025;
// A family is offered for a skill if it gives at least this fraction of the best family's points.
constexpr double kNearBest = 0.5;
// A family that trains nearly as many weak skills as the best one, by this fraction, may take its place for variety.
constexpr double kVaried = 0.8;
constexpr std::uint64_t kSeeds = 100'000;  // seeds are smaller than this

void describe_limits(Keys& keys, PathLimits& limits) {
  if (const auto families = keys("families", kNames, "allowed families; default: all"))
    for (const Json& family : families->items()) limits.families.push_back(family.string());
  keys("min_difficulty", limits.min_difficulty, {0, 1}, "least difficulty");
  keys("max_difficulty", limits.max_difficulty, {0, 1}, "largest difficulty");
  keys("in_order", limits.in_order, "true: a family follows when the skills of those before it are mastered");
}

}  // namespace

PathLimits read_limits(const std::filesystem::path& file, std::span<const CaseFamily> families) {
  const Json json = Json::load(file);
  const PathLimits limits = read_keys(json, describe_limits);
  std::vector<std::string> known;
  for (const CaseFamily& family : families) known.push_back(family.name);
  for (const std::string& name : limits.families)
    if (std::ranges::find(known, name) == known.end())
      json["families"].fail(name, fmt::format("families among {}", fmt::join(known, ", ")));
  if (json.has("families") && limits.families.empty()) json["families"].fail("at least one family");
  if (limits.min_difficulty > limits.max_difficulty)
    json.fail(fmt::format("min_difficulty {:g}", limits.min_difficulty),
              fmt::format("at most max_difficulty, {:g}", limits.max_difficulty));
  return limits;
}

std::vector<TrainedFamily> trained_by(const SkillTable& table, std::span<const CaseFamily> families) {
  std::vector<TrainedFamily> trained;
  for (const CaseFamily& family : families) {
    double all = 0;
    for (const auto& [item, weight] : family.weights) all += weight;
    std::vector<double> shares;
    for (const Skill& skill : table.skills) {
      double full = 0;
      for (const auto& [item, weight] : family.weights)
        if (std::ranges::find(skill.items, item) != skill.items.end()) full += weight;
      shares.push_back(all > 0 ? full / all : 0);
    }
    trained.push_back({family.name, std::move(shares)});
  }
  return trained;
}

std::uint64_t new_seed(const std::string& family, std::span<const PastSession> past, const std::string& trainee,
                       std::uint64_t n) {
  std::set<std::uint64_t> used;
  for (const PastSession& session : past)
    if (session.family == family) used.insert(session.seed);
  Sha256 key;
  for (const std::string& name : {trainee, family}) {
    key.add(name.size());
    key.bytes(name.data(), name.size());
  }
  SplitMix64 random{key.key()};
  for (;;) {
    const std::uint64_t seed = random.next() % kSeeds;
    if (!used.insert(seed).second) continue;
    if (n-- == 0) return seed;
  }
}

NextCase next_case(const SkillTable& table, std::span<const TrainedFamily> families, const PathLimits& limits,
                   std::span<const PastSession> past, std::span<const Mastery> mastery, const std::string& trainee) {
  std::vector<std::size_t> allowed;
  const auto take = [&](const std::string& name) {
    for (std::size_t i = 0; i < families.size(); ++i)
      if (families[i].name == name) allowed.push_back(i);
  };
  if (limits.families.empty())
    for (const TrainedFamily& family : families) take(family.name);
  else
    for (const std::string& name : limits.families) take(name);
  if (allowed.empty()) throw Error("next", "", "no family", "at least one family of cases");
  // Ability that gives the goal at the largest difficulty.
  const MasteryModel& model = table.model;
  const double aim = std::log(model.goal / (1 - model.goal)) + model.item_difficulty(limits.max_difficulty);
  const auto trains = [&](std::size_t family, std::size_t skill) {
    return families[family].shares[skill] >= kLeastTrained;
  };
  if (limits.in_order) {
    const auto mastered = [&](std::size_t family) {
      for (std::size_t skill = 0; skill < table.skills.size(); ++skill)
        if (trains(family, skill) && mastery[skill].ability < aim) return false;
      return true;
    };
    const auto first = std::ranges::find_if_not(allowed, mastered);
    if (first != allowed.end()) allowed.erase(first + 1, allowed.end());
  }

  NextCase next;
  double weakest = std::numeric_limits<double>::infinity();
  for (std::size_t skill = 0; skill < table.skills.size(); ++skill) {
    const bool trained = std::ranges::any_of(allowed, [&](std::size_t family) { return trains(family, skill); });
    if (trained && mastery[skill].ability < weakest) weakest = mastery[skill].ability, next.skill = skill;
  }
  const auto share = [&](std::size_t family) { return families[family].shares[next.skill]; };
  const double most = share(*std::ranges::max_element(allowed, {}, share));
  std::erase_if(allowed, [&](std::size_t family) { return share(family) < kNearBest * most; });
  // What the trainee lacks in the skills of a family, logits.
  const auto lacks = [&](std::size_t family) {
    double sum = 0;
    for (std::size_t skill = 0; skill < table.skills.size(); ++skill)
      if (trains(family, skill)) sum += std::max(0.0, aim - mastery[skill].ability);
    return sum;
  };
  const double largest = lacks(*std::ranges::max_element(allowed, {}, lacks));
  std::erase_if(allowed, [&](std::size_t family) { return lacks(family) < kVaried * largest; });
  const auto rank = [&](std::size_t family) {
    return std::pair(std::ranges::count(past, families[family].name, &PastSession::family), -share(family));
  };
  next.family = *std::ranges::min_element(allowed, {}, rank);
  const Mastery& of_skill = mastery[next.skill];
  const double wished = difficulty_for(model, of_skill, model.goal);
  next.difficulty = std::clamp(std::round(wished * 100) / 100, limits.min_difficulty, limits.max_difficulty);
  next.expected = expected_share(model, of_skill, next.difficulty);
  next.seed = new_seed(families[next.family].name, past, trainee, 0);
  return next;
}

}  // namespace typodont
