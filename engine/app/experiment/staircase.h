// Adaptive staircases: the next trial's difference from the earlier answers. Any thread.
#pragma once

#include <cmath>
#include <vector>

namespace typodont {

/// The level is the difference of a trial's stimuli. Changes are ratios, so it never reaches 0.
struct StaircaseRule {
  enum class Kind {
    /// Down after `down` right answers in a row, up after each wrong one (Levitt 1971).
    kTransformed,
    /// Down a little after each right answer, up more after each wrong one (Kaernbach 1991).
    kWeighted
  };
  Kind kind = Kind::kTransformed;
  /// kTransformed: settles at 0.5^(1/down) right answers.
  int down = 2;
  double weighted_at = 0.75;  // fraction right where kWeighted settles
  double start = 50;          // first level, in the experiment's unit
  double least = 1e-3, most = 100;
  double first_step = 1.6;  // ratio of levels in the first `coarse` reversals
  double step = 1.2;        // and afterwards
  int coarse = 3;           // reversals with `first_step`

  /// Fraction right where the staircase settles.
  double target() const { return kind == Kind::kTransformed ? std::pow(0.5, 1.0 / down) : weighted_at; }
};

class Staircase {
 public:
  explicit Staircase(const StaircaseRule& rule) : rule_(rule), level_(clamped(rule.start)) {}

  /// Of the next trial.
  double level() const { return level_; }
  /// `right`: of the present trial.
  void answer(bool right) {
    if (right && rule_.kind == StaircaseRule::Kind::kTransformed && ++in_a_row_ < rule_.down) return;
    in_a_row_ = 0;
    const int direction = right ? -1 : 1;
    if (direction_ != 0 && direction != direction_) turns_.push_back(level_);
    direction_ = direction;
    double step = std::log(static_cast<int>(turns_.size()) < rule_.coarse ? rule_.first_step : rule_.step);
    if (rule_.kind == StaircaseRule::Kind::kWeighted && !right) step *= rule_.weighted_at / (1 - rule_.weighted_at);
    level_ = clamped(level_ * std::exp(direction * step));
  }
  /// Reversals so far, from falling to rising or back.
  int turns() const { return static_cast<int>(turns_.size()); }
  /// Geometric mean at an even number of reversals after the first `coarse`; 0: too few.
  double settled_level() const {
    const int usable = (turns() - rule_.coarse) / 2 * 2;
    if (usable < 2) return 0;
    double sum = 0;
    for (int i = turns() - usable; i < turns(); ++i) sum += std::log(turns_[static_cast<std::size_t>(i)]);
    return std::exp(sum / usable);
  }

 private:
  double clamped(double level) const { return std::min(std::max(level, rule_.least), rule_.most); }

  StaircaseRule rule_;
  double level_;
  int in_a_row_ = 0;   // right answers since the last change
  int direction_ = 0;  // last change: 1 up, -1 down, 0 none
  std::vector<double> turns_;
};

}  // namespace typodont
