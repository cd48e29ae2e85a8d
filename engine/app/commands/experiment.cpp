// `typodont experiment`: two-alternative trials, with a person or with a simulated observer, and their evaluation.
#include "engine/app/experiment/experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/experiment/live_subject.h"
#include "engine/app/experiment/simulated_subject.h"
#include "engine/app/experiment/trial_log.h"
#include "engine/app/operator/library.h"
#include "engine/app/picture/hud.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/log.h"
#include "engine/base/progress.h"
#include "engine/base/units.h"
#include "haptics/contact_method.h"

namespace typodont {

namespace {

constexpr double kMaxDelay = 300;     // ms, largest delay of the force in a stimulus
constexpr double kMaxStiffness = 10;  // N/mm, largest stiffness of a stimulus

struct ExperimentOptions {
  std::string input, out, page, subject, hand, language, staircase = "2-down-1-up";
  std::string question = "stiffness";
  std::vector<std::string> models;
  std::optional<double> reference, start, observer;
  double bias = 0, lapse = 0, rate = 1000, seconds = 4;
  int trials = 150, turns = 24;
  std::uint64_t seed = 1;
  WorkbenchOptions workbench;
  bool json = false;
};

bool is_table(const std::string& file) {
  return kind_of_name(file, std::array{FileKind::kTable}) == FileKind::kTable;
}

void show(const ExperimentOptions& options, const TrialLog& log, const std::string& file) {
  const ExperimentResult result = result_of(log.plan, log.answered);
  if (!options.page.empty()) {
    std::string title = fmt::format("Experiment: {}", name_of(log.plan.question));
    if (!log.subject.empty()) title += ", " + log.subject;
    write_file_atomically(options.page, page_of(log.plan, result, log.answered, title), FileKind::kPage);
  }
  fmt::print("{}\n", options.json ? json_of(result, file) : words_of(result));
  if (options.json) return;
  if (file != options.input) fmt::print("wrote {}\n", file);
  if (!options.page.empty()) fmt::print("wrote {}\n", options.page);
}

StaircaseRule rule_of(const std::string& name) {
  StaircaseRule rule;
  if (name == "weighted") rule.kind = StaircaseRule::Kind::kWeighted;
  if (name == "3-down-1-up") rule.down = 3;
  return rule;
}

ExperimentPlan plan_of(const ExperimentOptions& options, const Scene& scene) {
  ExperimentPlan plan;
  const auto name = std::find(kQuestionNames.begin(), kQuestionNames.end(), options.question);
  plan.question = static_cast<Question>(name - kQuestionNames.begin());
  plan.trials = options.trials, plan.turns = options.turns, plan.seed = options.seed;
  plan.scene_stiffness = scene.servo.stiffness;
  if (plan.question == Question::kModel) {
    if (options.models.size() != 2 || options.models[0] == options.models[1])
      throw Error("--models", "", fmt::format("{} of them", options.models.size()), "two different contact models");
    for (std::size_t i = 0; i < 2; ++i) {
      Scene known = scene;
      // the result is not used; the call only throws Error if the model is unknown
      choose_model(known, options.models[i]);
      plan.models[i] = options.models[i];
    }
    if (options.observer && options.hand.empty())
      throw Error("--hand", "", "none", "a path for the simulated observer, who has to feel the models");
    return plan;
  }
  if (!options.models.empty()) throw Error("--models", "", "it beside another question", "--question model");
  plan.rule = rule_of(options.staircase);
  double most = 0;  // largest allowed value of a stimulus (reference plus difference)
  switch (plan.question) {
    case Question::kStiffness:
      most = kMaxStiffness;
      // By default, the reference is the stiffness of the scene's coupling (spring between hand and tool), but at most
      // half of the largest allowed value, so that stiffer stimuli are possible.
      plan.reference = options.reference.value_or(std::min(plan.scene_stiffness / kNewtonPerMillimetre, most / 2));
      break;
    case Question::kForce:
      plan.reference = options.reference.value_or(50), most = 100;
      break;
    case Question::kDelay:
      plan.reference = options.reference.value_or(0), most = kMaxDelay;
      break;
    case Question::kModel:
      break;
  }
  const bool delay = plan.question == Question::kDelay;
  if (!(plan.reference >= 0 && plan.reference < most && (delay || plan.reference > 0)))
    throw Error("--reference", "", fmt::format("{:g}", plan.reference),
                fmt::format("{}, less than {:g}", delay ? "0 or more" : "more than 0", most));
  plan.rule.most = delay ? most - plan.reference : 100 * (most / plan.reference - 1);
  if (!delay) plan.rule.most = std::min(plan.rule.most, 400.0);
  plan.rule.least = delay ? 1 : 0.1;
  plan.rule.start = options.start.value_or(std::min(plan.rule.most, delay ? 100.0 : 50.0));
  if (!(plan.rule.start >= plan.rule.least && plan.rule.start <= plan.rule.most))
    throw Error("--start", "", fmt::format("{:g}", plan.rule.start),
                fmt::format("{:g} to {:g} {}", plan.rule.least, plan.rule.most, unit_of(plan.question)));
  return plan;
}

void run_simulated(const ExperimentOptions& options, const Scene& scene, Experiment& experiment, TrialLog& log) {
  const Psychometric truth{options.bias, Psychometric::width_of_jnd(*options.observer), options.lapse};
  // With this constant, the observer's random sequence differs from the one that orders the trials.
  SimulatedObserver observer(truth, options.seed ^ 0x9E3779B97F4A7C15u);
  std::optional<ScriptedTouch> touch;
  if (!options.hand.empty()) touch.emplace(scene, options.hand, options.rate);
  Progress progress("experiment");
  while (!experiment.over()) {
    const Trial& trial = experiment.trial();
    progress.at(static_cast<double>(trial.number - 1) / experiment.plan().trials);
    const double difference =
        touch ? touch->measured_difference(experiment.plan().question, trial) : nominal_difference(trial);
    experiment.answer(observer.judge(difference), 0);
  }
  progress.at(1);
  log.answered = experiment.answered();
  write_trial_log(options.out, log);
}

void run_live(const ExperimentOptions& options, const Scene& scene, Experiment& experiment, TrialLog& log) {
  LiveSubject::Options live;
  live.workbench = options.workbench;
  live.workbench.hand = options.hand;
  live.workbench.rate = options.rate;
  live.workbench.language = hud_language(user_language(options.language));
  live.question = experiment.plan().question;
  live.seconds = options.seconds;
  if (live.question == Question::kDelay) live.max_delay = kMaxDelay * 1e-3;
  LiveSubject subject(scene, live);
  while (!experiment.over()) {
    const Trial& trial = experiment.trial();
    const std::optional<LiveSubject::Given> given =
        subject.ask(trial, fmt::format("{} / {}", trial.number, experiment.plan().trials));
    if (!given) break;
    experiment.answer(given->answer, given->seconds);
    log.answered = experiment.answered();
    write_trial_log(options.out, log);
    log::info("experiment: {:.0f} %", 100 * experiment.fraction());
  }
  subject.stop();
  if (!experiment.over())
    throw RunFailure(fmt::format("the session ended after {} trials; {}", log.answered.size(),
                                 log.answered.empty() ? "nothing was written" : options.out + " has them"));
}

void run(const ExperimentOptions& options) {
  if (is_table(options.input)) return show(options, read_trial_log(options.input), options.input);
  const Scene scene = read_scene(options.input);
  const ExperimentPlan plan = plan_of(options, scene);
  Experiment experiment(plan);
  TrialLog log{plan, options.input, options.subject, {}};
  if (options.observer) {
    run_simulated(options, scene, experiment, log);
  } else {
    run_live(options, scene, experiment, log);
  }
  show(options, log, options.out);
}

}  // namespace

void add_experiment_command(cli::Command& app) {
  auto options = std::make_shared<ExperimentOptions>();
  ExperimentOptions& o = *options;
  cli::Command* command = app.add_command(
      "experiment", "Find what a hand can just tell apart: two stimuli a trial, and which was greater?");
  command->footer(
      "Examples:\n"
      "  typodont experiment assets/scenes/explore-caries.json --question stiffness --out trials.csv --page "
      "result.html\n"
      "  typodont experiment assets/scenes/explore-caries.json --question model --models offset mesh_lod --trials 40 "
      "--out trials.csv\n"
      "  typodont experiment assets/scenes/explore-caries.json --question delay --observer 20 --out trials.csv\n"
      "  typodont experiment trials.csv --page result.html");
  command->add_option("input", o.input, "scene (.json) to feel, or the log (.csv) of earlier trials, to fit it again")
      ->required();
  command->add_option("--out", o.out, "log of the trials to write (.csv), whole after every trial",
                      cli::writes({FileKind::kTable}));
  command->add_option("--page", o.page, "result to write as a page (.html)", cli::writes({FileKind::kPage}));
  command->add_option("--subject", o.subject, "the person's name or code, written into the log and onto the page");
  command->add_setting("--question", o.question, "what differs: stiffness, force, delay of the force, or the model",
                       cli::one_of({kQuestionNames.begin(), kQuestionNames.end()}));
  command->add_option("--models", o.models, "of --question model: two of " + haptics::known_contact_methods())
      ->expected(2);
  command->add_option(
      "--reference", o.reference,
      "the lesser stimulus: N/mm (default: the scene's coupling, at most 5), % of the force (50), ms (0)");
  command->add_option("--start", o.start, "first difference, % or ms (50 %, 100 ms)");
  command->add_setting("--staircase", o.staircase, "rule by which the difference changes",
                       cli::one_of({"2-down-1-up", "3-down-1-up", "weighted"}));
  command->add_setting("--trials", o.trials, "trials, at most; of models: exactly", cli::range(1, 10000));
  command->add_setting("--turns", o.turns, "turns of the staircase, after which it ends", cli::range(2, 1000));
  command->add_setting("--seed", o.seed, "of the random order, and of a simulated observer");
  command->add_option("--observer", o.observer,
                      "instead of a person, a simulated observer with this just-noticeable difference, % or ms",
                      cli::more_than_zero());
  command->add_setting("--bias", o.bias, "the observer's: how much greater the second must be, % or ms");
  command->add_setting("--lapse", o.lapse, "the observer's: share of trials answered by chance", cli::range(0.0, 1.0));
  command->add_option("--hand", o.hand,
                      "of a person: as of run; of an observer: HAND.csv or HAND.json that feels each stimulus");
  command->add_setting("--rate", o.rate, "servo rate of hands that leave the choice, Hz", cli::range(10.0, 100000.0));
  command->add_setting("--seconds", o.seconds, "that a person feels each stimulus", cli::range(0.05, 600.0));
  WorkbenchOptions& w = o.workbench;
  command->add_option("--rig", w.rig, "as of run");
  command->add_option("--audio", w.audio, "as of run");
  command->add_option("--language", o.language, "as of run");
  command->add_flag("--no-real-time", w.no_real_time, "as of run");
  command->add_flag("--json", o.json, "print the result as JSON");
  command->callback([options, command] {
    const bool trials = !is_table(options->input);
    if (trials && options->out.empty()) throw Error("--out", "", "none", "a file for the trials (.csv)");
    command->refuse_without(
        {"--out", "--subject", "--question", "--models", "--reference", "--start", "--staircase", "--trials", "--turns",
         "--seed", "--observer", "--hand", "--rate", "--seconds", "--rig", "--audio", "--language", "--no-real-time"},
        trials, "a scene");
    command->refuse_without({"--bias", "--lapse"}, options->observer.has_value(), "--observer");
    command->refuse_without({"--seconds", "--rig", "--audio", "--language", "--no-real-time"},
                            !options->observer.has_value(), "a person");
    run(*options);
  });
}

}  // namespace typodont
