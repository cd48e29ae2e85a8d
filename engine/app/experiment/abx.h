// Blind comparison of two sounds (ABX): in each trial the listener hears A, B and X, and says which of the two X is.
// Which one it is stands only in the key, which is kept apart from the page that the listener sees.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/app/experiment/psychometric.h"

namespace typodont {

struct AbxKey {
  std::string a, b;  // names of the sounds
  std::uint64_t seed = 1;
  std::vector<bool> x_is_b;  // for each trial
};

/// As many trials with X = A as with X = B (one more of either if the number is odd), in random order.
AbxKey abx_key(const std::string& a, const std::string& b, int trials, std::uint64_t seed);
std::string to_json(const AbxKey& key);
/// Throws Error naming file, key, found and expected.
AbxKey load_abx_key(const std::filesystem::path& file);
/// Answers as the page gives them, one line a trial: its number from 1, and A or B. Throws Error for a line that is
/// something else, a trial that is missing, answered twice or unknown.
std::vector<bool> load_abx_answers(const std::filesystem::path& file, std::size_t trials);

struct AbxResult {
  int trials = 0, right = 0;
  Estimate fraction;  // fraction of right answers, with its 95 % interval
  double chance = 1;  // probability of a result this far from half if the listener hears no difference
};
AbxResult judge(const AbxKey& key, const std::vector<bool>& said_b);

/// A self-contained page: players for A and B, and for each trial a player for X. `sounds`: WAV files as bytes, A and B
/// and then X of each trial.
std::string abx_page(const AbxKey& key, const std::vector<std::vector<std::uint8_t>>& sounds);

}  // namespace typodont
