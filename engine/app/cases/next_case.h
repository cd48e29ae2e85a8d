// Chooses the next case for a trainee (docs/cases.md).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "engine/app/cases/mastery.h"

namespace typodont {

/// A teacher's limits.
struct PathLimits {
  std::vector<std::string> families;  // allowed families; empty: all
  double min_difficulty = 0, max_difficulty = 1;
  bool in_order = false;  // true: a family follows when the skills of those before it are mastered
};
/// Reads the limits. Throws Error, also for an unknown family.
PathLimits read_limits(const std::filesystem::path& file, std::span<const CaseFamily> families);

/// A family and the skills that it trains. `shares`: for each skill of the table, its fraction of the family's points.
struct TrainedFamily {
  std::string name;
  std::vector<double> shares;
};
std::vector<TrainedFamily> trained_by(const SkillTable& table, std::span<const CaseFamily> families);

struct NextCase {
  std::size_t family = 0, skill = 0;  // index of the family, and of the skill that it should train
  double difficulty = 0;
  std::uint64_t seed = 0;
  double expected = 0;  // expected fraction of the skill's points
};
/// Chooses the weakest skill, a family that trains it, and a difficulty at which the trainee should reach the model's
/// goal. Equal arguments give equal cases. `trainee` makes the seed differ between persons.
NextCase next_case(const SkillTable& table, std::span<const TrainedFamily> families, const PathLimits& limits,
                   std::span<const PastSession> past, std::span<const Mastery> mastery, const std::string& trainee);

/// The seed of the case number `n` (from 0) of a family; no seed of `past` in this family.
std::uint64_t new_seed(const std::string& family, std::span<const PastSession> past, const std::string& trainee,
                       std::uint64_t n);

}  // namespace typodont
