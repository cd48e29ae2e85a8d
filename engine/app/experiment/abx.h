// Blind comparison of two sounds (ABX). In each trial the listener hears A, B and X, and says whether X is A or B. The
// right answers are only in the key, a file that the listener does not see.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/app/experiment/psychometric.h"

namespace typodont {

struct AbxKey {
  std::string a, b;  // names of the two sounds A and B that are compared
  std::uint64_t seed = 1;
  std::vector<bool> x_is_b;  // one value for each trial: true if X is B
};

/// Makes a key in which X is A as often as it is B, in random order. If the number of trials is odd, one of the two
/// occurs once more.
AbxKey abx_key(const std::string& a, const std::string& b, int trials, std::uint64_t seed);
std::string to_json(const AbxKey& key);
/// Reads a key. Throws Error that names the file, the JSON key, the value found and the value expected.
AbxKey load_abx_key(const std::filesystem::path& file);
/// Reads the answers. Each line contains the number of a trial, counted from 1, and A or B. Throws Error if a line is
/// invalid, or if a trial is missing, unknown or answered twice.
std::vector<bool> load_abx_answers(const std::filesystem::path& file, std::size_t trials);

struct AbxResult {
  int trials = 0, right = 0;
  Estimate fraction;  // fraction of right answers, with its 95 % confidence interval
  /// p-value. If a listener hears no difference, half of the answers are right on average. This is the probability that
  /// the fraction of right answers of such a listener differs from one half by at least as much as `fraction` does.
  double chance = 1;
};
AbxResult judge(const AbxKey& key, const std::vector<bool>& said_b);

/// Makes a self-contained page with players for A and B, and a player for X in each trial. `sounds`: the bytes of WAV
/// files in this order: A, B, then the X of each trial.
std::string abx_page(const AbxKey& key, const std::vector<std::vector<std::uint8_t>>& sounds);

}  // namespace typodont
