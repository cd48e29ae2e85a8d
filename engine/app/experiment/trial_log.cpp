#include "engine/app/experiment/trial_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "engine/base/csv.h"
#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/json.h"

namespace typodont {

namespace {

constexpr std::string_view kPlan = "# plan ";  // start of the first line, followed by the plan as JSON

/// Names of the columns that depend on the question.
struct Columns {
  std::string first, second, level;
};
Columns columns_of(Question question) {
  static const std::map<Question, Columns> kColumns{
      {Question::kStiffness, {"first_N_per_mm", "second_N_per_mm", "level_percent"}},
      {Question::kForce, {"first_force_percent", "second_force_percent", "level_percent"}},
      {Question::kDelay, {"first_delay_ms", "second_delay_ms", "level_ms"}},
      {Question::kModel, {"first_model", "second_model", ""}}};
  return kColumns.at(question);
}

std::string plan_text(const TrialLog& log) {
  const ExperimentPlan& plan = log.plan;
  nlohmann::ordered_json json = {{"question", name_of(plan.question)}, {"scene", log.scene}, {"seed", plan.seed}};
  if (!log.subject.empty()) json["subject"] = log.subject;
  if (plan.question == Question::kModel) {
    json["models"] = plan.models;
    return json.dump();
  }
  const StaircaseRule& rule = plan.rule;
  json["reference"] = plan.reference;
  json["staircase"] = {{"rule", rule.kind == StaircaseRule::Kind::kWeighted ? "weighted" : "transformed"},
                       {"down", rule.down},
                       {"weighted_at", rule.weighted_at},
                       {"start", rule.start},
                       {"least", rule.least},
                       {"most", rule.most},
                       {"first_step", rule.first_step},
                       {"step", rule.step},
                       {"coarse", rule.coarse}};
  return json.dump();
}

TrialLog read_plan(const std::filesystem::path& file) {
  LineReader lines(file, InputKind::kTable);
  std::string line;
  if (!lines.next(line) || !line.starts_with(kPlan))
    throw Error(file.string(), "line 1", line,
                "the log of an experiment, which begins with \"" + std::string(kPlan) + "\"");
  const Json json = Json::parse(line.substr(kPlan.size()), file.string());
  TrialLog log;
  ExperimentPlan& plan = log.plan;
  const auto name = std::find(kQuestionNames.begin(), kQuestionNames.end(), json["question"].string());
  if (name == kQuestionNames.end()) json["question"].fail("stiffness, force, delay or model");
  plan.question = static_cast<Question>(name - kQuestionNames.begin());
  log.scene = json["scene"].string();
  if (json.has("subject")) log.subject = json["subject"].string();
  plan.seed = static_cast<std::uint64_t>(json["seed"].integer(0));
  if (plan.question == Question::kModel) {
    const std::vector<Json> models = json["models"].items();
    if (models.size() != 2) json["models"].fail("two models");
    for (std::size_t i = 0; i < 2; ++i) plan.models[i] = models[i].string();
    return log;
  }
  plan.reference = json["reference"].number(0, 1e9);
  const Json staircase = json["staircase"];
  StaircaseRule& rule = plan.rule;
  rule.kind =
      staircase["rule"].string() == "weighted" ? StaircaseRule::Kind::kWeighted : StaircaseRule::Kind::kTransformed;
  rule.down = static_cast<int>(staircase["down"].number(1, 10));
  rule.weighted_at = staircase["weighted_at"].number(0.5, 1);
  rule.start = staircase["start"].number(0, 1e9);
  rule.least = staircase["least"].number(0, 1e9), rule.most = staircase["most"].number(0, 1e9);
  rule.first_step = staircase["first_step"].number(1, 1e3), rule.step = staircase["step"].number(1, 1e3);
  rule.coarse = static_cast<int>(staircase["coarse"].number(0, 1e6));
  return log;
}

}  // namespace

std::string table_of(const TrialLog& log) {
  const Columns columns = columns_of(log.plan.question);
  const bool models = log.plan.question == Question::kModel;
  std::string text = fmt::format("{}{}\n", kPlan, plan_text(log));
  text += fmt::format("trial,{},{},{}{}answer,right,answer_s\n", columns.first, columns.second, columns.level,
                      models ? "" : ",");
  for (const AnsweredTrial& a : log.answered) {
    const Trial& trial = a.trial;
    if (models) {
      text += fmt::format("{},{},{},", trial.number, trial.stimuli[0].model, trial.stimuli[1].model);
    } else {
      text += fmt::format("{},{:.17g},{:.17g},{:.17g},", trial.number, trial.values[0], trial.values[1], trial.level);
    }
    text += fmt::format("{},{},{:.3f}\n", a.answer == Answer::kSecond ? 2 : 1, a.right() ? 1 : 0, a.seconds);
  }
  return text;
}

void write_trial_log(const std::filesystem::path& file, const TrialLog& log) {
  write_file_atomically(file, table_of(log), FileKind::kTable);
}

TrialLog read_trial_log(const std::filesystem::path& file) {
  TrialLog log = read_plan(file);
  const bool models = log.plan.question == Question::kModel;
  const Columns names = columns_of(log.plan.question);
  std::vector<std::string> required{"trial", names.first, names.second, "answer", "right", "answer_s"};
  std::map<std::string, CellReader> readers;
  if (models) {
    const CellReader model{[&](std::string_view cell) {
                             const auto at = std::find(log.plan.models.begin(), log.plan.models.end(), cell);
                             return at == log.plan.models.end() ? std::numeric_limits<double>::quiet_NaN()
                                                                : static_cast<double>(at - log.plan.models.begin());
                           },
                           fmt::format("{} or {}", log.plan.models[0], log.plan.models[1])};
    readers = {{names.first, model}, {names.second, model}};
  } else {
    required.push_back(names.level);
  }
  const CsvTable table = read_csv(file, required, {}, readers);
  const auto at = [&](std::size_t row, const std::string& column) { return table.value(row, column); };
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    AnsweredTrial a;
    a.trial.number = static_cast<int>(at(row, "trial"));
    a.trial.values = {at(row, names.first), at(row, names.second)};
    if (models) {
      for (std::size_t i = 0; i < 2; ++i)
        a.trial.stimuli[i].model = log.plan.models[static_cast<std::size_t>(a.trial.values[i])];
    } else {
      a.trial.level = at(row, names.level);
      if (!(a.trial.level > 0)) table.fail(row, names.level, fmt::format("{}", a.trial.level), "more than 0");
    }
    if (a.trial.values[0] == a.trial.values[1])
      table.fail(row, names.second, fmt::format("{}", a.trial.values[1]), "another stimulus than the first");
    a.trial.greater_second = a.trial.values[1] > a.trial.values[0];
    const double answer = at(row, "answer");
    if (answer != 1 && answer != 2) table.fail(row, "answer", fmt::format("{}", answer), "1 (first) or 2 (second)");
    a.answer = answer == 2 ? Answer::kSecond : Answer::kFirst;
    if ((at(row, "right") != 0) != a.right())
      table.fail(row, "right", fmt::format("{}", at(row, "right")), a.right() ? "1" : "0");
    a.seconds = at(row, "answer_s");
    log.answered.push_back(std::move(a));
  }
  return log;
}

}  // namespace typodont
