#include "engine/app/cases/mastery.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/app/assets.h"
#include "engine/base/keys.h"

namespace typodont {

namespace {

// Fractions of the points are limited to this distance from 0 and 1, whose logits are infinite.
constexpr double kLeastShare = 0.02;

double logit(double p) {
  return std::log(p / (1 - p));
}
double logistic(double x) {
  return 1 / (1 + std::exp(-x));
}

/// Factor by which the spread of the logit flattens the mean of its logistic function (MacKay 1992).
double flattening(const MasteryModel& model, const Mastery& mastery) {
  const double variance = mastery.variance + model.noise_sd * model.noise_sd;
  return 1 / std::sqrt(1 + std::numbers::pi * variance / 8);
}

void describe_model(Keys& keys, MasteryModel& m) {
  constexpr Range kLogits{1e-3, 10};
  keys(must("prior_sd"), m.prior_sd, kLogits, "deviation of the abilities of new trainees");
  keys(must("noise_sd"), m.noise_sd, kLogits, "deviation of a session's logit");
  keys(must("session_sd"), m.session_sd, kLogits, "change of the ability between two sessions");
  keys(must("day_sd"), m.day_sd, kLogits, "change of the ability per square root of a day");
  keys(must("span"), m.span, kLogits, "difference between the difficulties 1 and 0");
  keys(must("goal"), m.goal, {0.55, 0.95}, "fraction of the points that the next case should give");
  keys.ignore("source");
}

void describe_skill(Keys& keys, Skill& skill) {
  keys(must("name"), skill.name, "name of the skill");
  if (const auto title = keys(must("title"), kAnyObject, "title in three languages"))
    skill.title = session::read_task_text(*title);
  if (const auto items = keys(must("items"), kNames, "items of the score"))
    for (const Json& item : items->items()) skill.items.push_back(item.string());
}

void describe_table(Keys& keys, SkillTable& table) {
  keys(must("model"), table.model, describe_model, "parameters of the estimate");
  keys(must("skills"), table.skills, describe_skill, "the skills");
}

}  // namespace

SkillTable skill_table() {
  return read_keys(Json::load(assets_folder() / "cases" / "skills.json"), describe_table);
}

Mastery unknown_mastery(const MasteryModel& model) {
  return {0, model.prior_sd * model.prior_sd, 0};
}

void observe(const MasteryModel& model, Mastery& mastery, double difficulty, double share, double days) {
  const double noise = model.noise_sd * model.noise_sd;
  if (mastery.sessions > 0)
    mastery.variance += model.session_sd * model.session_sd + model.day_sd * model.day_sd * std::max(0.0, days);
  // After a long pause, the trainee is not less known than a new one.
  mastery.variance = std::min(mastery.variance, model.prior_sd * model.prior_sd);
  const double seen = logit(std::clamp(share, kLeastShare, 1 - kLeastShare)) + model.item_difficulty(difficulty);
  const double gain = mastery.variance / (mastery.variance + noise);
  mastery.ability += gain * (seen - mastery.ability);
  mastery.variance *= 1 - gain;
  ++mastery.sessions;
}

double expected_share(const MasteryModel& model, const Mastery& mastery, double difficulty) {
  return logistic(flattening(model, mastery) * (mastery.ability - model.item_difficulty(difficulty)));
}

double warning_level(const MasteryModel& model, const Mastery& mastery) {
  constexpr double kNew = 0.5;  // expected fraction of a new trainee
  return std::clamp((model.goal - expected_share(model, mastery, 0.5)) / (model.goal - kNew), 0.0, 1.0);
}

double difficulty_for(const MasteryModel& model, const Mastery& mastery, double share) {
  return 0.5 + (mastery.ability - logit(share) / flattening(model, mastery)) / model.span;
}

std::vector<std::optional<double>> shares_of(const SkillTable& table, std::span<const ItemPoints> items,
                                             double completion) {
  std::vector<std::optional<double>> shares;
  for (const Skill& skill : table.skills) {
    double points = 0, full = 0;
    for (const ItemPoints& item : items) {
      if (std::ranges::find(skill.items, item.name) == skill.items.end()) continue;
      points += item.points, full += item.full;
    }
    shares.push_back(full > 0 ? std::optional(completion * points / full) : std::nullopt);
  }
  return shares;
}

std::vector<Mastery> mastery_after(const SkillTable& table, std::span<const PastSession> sessions) {
  std::vector<Mastery> all(table.skills.size(), unknown_mastery(table.model));
  std::vector<std::optional<double>> last(all.size());  // day of the skill's last session
  for (const PastSession& session : sessions)
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (!session.shares[i]) continue;
      const double days = session.day && last[i] ? *session.day - *last[i] : 0;
      observe(table.model, all[i], session.difficulty, *session.shares[i], days);
      if (session.day) last[i] = session.day;
    }
  return all;
}

}  // namespace typodont
