#include "engine/app/bench/models_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <string_view>
#include <utility>

#include "engine/app/bench/page_text.h"
#include "engine/app/bench/plot.h"
#include "engine/app/bench/row_origin.h"
#include "engine/app/bench/stored_rows.h"
#include "engine/base/error.h"
#include "engine/base/file_kind.h"
#include "engine/base/json.h"
#include "haptics/contact_method.h"

namespace typodont {

namespace {

/// Returns the different values of a member, each once, in the order of their first occurrence.
std::vector<std::string> distinct(const std::vector<ModelFigure>& figures, std::string ModelFigure::*member) {
  std::vector<std::string> all;
  for (const ModelFigure& f : figures)
    if (std::find(all.begin(), all.end(), f.*member) == all.end()) all.push_back(f.*member);
  return all;
}

/// A question on the page. The answer is one quantity (`measure`) of one motion of the hand (`motion`), taken from the
/// benchmark's result rows whose unit ends with `unit`.
struct Question {
  const char *title, *text, *file;
  const char *motion, *measure, *unit;
  const char* y_label;
};

constexpr Question kPlotted[] = {
    {"How accurate is the direction of the force?",
     "The hand slides over the tissue with 20 mm/s, at a depth of 0.3 mm. The error of the direction is the angle "
     "between the model force and the exact force.",
     "direction", "slide", "direction", "rms", "direction error, degree rms"},
    {"How accurate is the magnitude of the force?",
     "The table states the relative error of the magnitude of the model force while the hand slides.", "magnitude",
     "slide", "magnitude", "rms", "magnitude error, % rms"},
    {"Is the tool drawn inside the tissue?",
     "The table states the largest depth of the drawn tool inside the exact shape while the hand slides.",
     "penetration", "slide", "penetration", "greatest", "penetration, mm"},
    {"Does the removed volume equal the swept volume?",
     "A hand of 0.15 kg presses a round bur of 1.2 mm with 1 N and moves it back and forth. The test compares the "
     "volume that the tissue has lost with the swept volume. The swept volume is the part of the exact shape through "
     "which the bur's cuts passed, counted on a grid of 0.02 mm.",
     "removal", "drill", "removal", "swept volume", "removal error, % of the swept volume"}};

bool answers(const ModelFigure& f, const Question& q) {
  return f.motion == q.motion && f.measure == q.measure && f.row->error_unit.ends_with(q.unit);
}

std::vector<Plot> panels_of(const std::vector<ModelFigure>& figures, const Question& q) {
  const std::vector<std::string> models = distinct(figures, &ModelFigure::model);
  std::vector<Plot> panels;
  for (const std::string& tissue : distinct(figures, &ModelFigure::tissue)) {
    Plot plot{tissue, "servo's tick, median, ns", q.y_label, {}};
    // adds all series first, so that a model has the same colour in every panel
    for (const std::string& model : models) plot.of(model);
    bool any = false;
    for (const ModelFigure& f : figures) {
      if (f.tissue != tissue || !answers(f, q) || !(f.row->error > 0) || !(f.row->time_ns > 0)) continue;
      plot.of(f.model).points.push_back({f.row->time_ns, f.row->error, f.row->knob});
      any = true;
    }
    if (any) panels.push_back(std::move(plot));
  }
  return panels;
}

std::string number(double v) {
  if (!std::isfinite(v)) return "–";
  if (v == 0) return "0";
  return std::abs(v) >= 0.01 && std::abs(v) < 1e5 ? fmt::format("{:.3g}", v) : fmt::format("{:.1e}", v);
}

/// A function that takes from a row the value that is shown in a cell of the table.
using CellOf = std::function<double(const BenchRow&)>;
double error_of(const BenchRow& row) {
  return row.error;
}
double microseconds_of(const BenchRow& row) {
  return row.time_ns * 1e-3;
}

/// Finds the row that answers a question of the page for a contact model and a tissue. If the model was measured at
/// several resolutions, this is the last row, which has the finest resolution. Null if there is no such row.
const BenchRow* answer(const std::vector<ModelFigure>& figures, const Question& q, const std::string& model,
                       const std::string& tissue) {
  const BenchRow* row = nullptr;
  for (const ModelFigure& f : figures)
    if (f.model == model && f.tissue == tissue && answers(f, q)) row = f.row;
  return row;
}

/// Returns the tissues for which the rows contain an answer to the question of the page, each once.
std::vector<std::string> tissues_of(const std::vector<ModelFigure>& figures, const Question& q) {
  std::vector<ModelFigure> asked;
  std::ranges::copy_if(figures, std::back_inserter(asked), [&](const ModelFigure& f) { return answers(f, q); });
  return distinct(asked, &ModelFigure::tissue);
}

/// Makes a table with a row per model and a column per tissue. Each cell shows the model at its finest resolution.
std::string table_of(const std::vector<ModelFigure>& figures, const Question& q, const CellOf& cell) {
  const std::vector<std::string> tissues = tissues_of(figures, q);
  if (tissues.empty()) return {};
  std::string out = "| model |", line = "|---|";
  for (const std::string& tissue : tissues) out += fmt::format(" {} |", tissue), line += "---|";
  out += "\n" + line + "\n";
  for (const std::string& model : distinct(figures, &ModelFigure::model)) {
    out += fmt::format("| `{}` |", model);
    for (const std::string& tissue : tissues) {
      const BenchRow* row = answer(figures, q, model, tissue);
      out += fmt::format(" {} |", row ? number(cell(*row)) : "–");
    }
    out += "\n";
  }
  return out;
}

struct Tabled {
  Question question;
  double (*cell)(const BenchRow&);
};
constexpr Tabled kTabled[] = {
    {{"Does friction follow Coulomb's law?",
      "The hand slides with a friction coefficient of 0.15. The table states the error of the ratio of tangential to "
      "normal force, relative to 0.15, in % (root mean square). If the ball sticks to the tissue, this counts as an "
      "error. In the groove, the ball touches two walls, so the contact has no single normal.",
      "", "drag", "friction", "rms", ""},
     error_of},
    {{"How long does a tick take at worst?",
      "The table states the CPU time of the servo's tick while the hand slides (99.9 % quantile, µs).", "", "slide",
      "tick, 99.9 %", "", ""},
     microseconds_of},
    {{"How long does a tick take while drilling?",
      "The table states the CPU time of the servo's tick while the bur cuts (99.9 % quantile, µs).", "", "drill",
      "tick, 99.9 %", "", ""},
     microseconds_of},
    {{"How long does a cut take in the carver?",
      "The table states the CPU time of the carver thread for one cut (median, µs).", "", "drill",
      "carver's cut, median", "", ""},
     microseconds_of},
    {{"How large is the largest step of the model force?",
      "The table states the largest change of the model force in one tick while the hand slides, minus the change of "
      "the exact force in the same tick (N).",
      "", "slide", "step, asked", "", ""},
     error_of},
    {{"How large is the largest step of the output force?",
      "The table states the largest change of the output force in one tick while the hand slides, minus the change of "
      "the exact force in the same tick (N). The output force is the force after slew limit, force limit and passivity "
      "controller.",
      "", "slide", "step, felt", "", ""},
     error_of},
    {{"How much energy does the model force of a tap give to the hand?",
      "The hand touches the tissue briefly (a tap) with 10, 30, 100 and 200 mm/s, 0.3 mm deep. The table states the "
      "largest energy that the model force gives to the hand (µJ).",
      "", "tap", "energy given, asked", "", ""},
     error_of},
    {{"How much energy does the output force of a tap give to the hand?",
      "The table states the largest energy that the output force gives to the tapping hand, after the passivity "
      "controller (µJ).",
      "", "tap", "energy given, felt", "", ""},
     error_of},
    {{"How long does the bur take to drill through a sheet?",
      "The hand presses the bur with 1 N on a sheet of 0.3 mm. The table states the time in seconds until the bur has "
      "left the sheet, or – if the bur did not leave the sheet in 1.5 s.",
      "", "break-through", "time", "", ""},
     error_of},
    {{"How large is the force behind the sheet?",
      "The table states the largest force after the bur has left the sheet (N).", "", "break-through", "force left", "",
      ""},
     error_of},
    {{"Do hands escape through thin walls at 1 mm per tick?",
      "A ball moves through a sheet and stays at least 4 mm behind the sheet. If no force behind the sheet pushes "
      "the hand back, the hand has escaped. The table shows the percentage of hands that escape for each thickness of "
      "the sheet, with random positions and directions.",
      "", "escape", "hands of 1 mm a tick", "", ""},
     error_of},
    {{"Do hands escape at 20 mm per tick?",
      "The ball moves through the sheet with 20 mm per tick. The table shows the percentage of hands that escape, "
      "which means that no force behind the sheet pushes them back.",
      "", "escape", "hands of 20 mm a tick", "", ""},
     error_of},
    {{"How much energy do hostile hands get?",
      "Hostile hands move at random with up to 0.2 m/s and 20 m/s², turn in all directions and drill. The table states "
      "the largest energy (µJ) that the output force gives to any hand that moves fast and at random.",
      "", "hostile", "energy given, felt", "", ""},
     error_of},
    {{"How many hostile hands get energy?",
      "The table states the percentage of hostile hands to which the output force gives more than 1 nJ.", "", "hostile",
      "hands with energy", "", ""},
     error_of},
    {{"Are all forces on hostile hands finite?",
      "The table states the number of ticks in which the force on a hostile hand is not finite.", "", "hostile",
      "ticks not finite", "", ""},
     error_of},
    {{"How long does a tick with a hostile hand take at worst?",
      "The table states the CPU time of the servo's tick with a hostile hand (99.9 % quantile, µs).", "", "hostile",
      "tick, 99.9 %", "", ""},
     microseconds_of},
    {{"How much memory does the set-up need?",
      "The table states the memory of tissue, snapshots and contact model (MiB).", "", "set-up", "memory", "", ""},
     error_of},
    {{"How long does the set-up take?",
      "The table states the CPU time that all threads need to set up a contact model (s).", "", "set-up", "time", "",
      ""},
     error_of}};

/// A task in the table of recommendations. A contact model fails in the task if its ticks take too long at every
/// resolution (kMostTick), or if the hand falls through the tissue. Of the models that do not fail, the one with the
/// smallest score() is the best.
struct Task {
  const char* task;
  Question question;
  std::vector<std::string> tissues;
  double (*cell)(const BenchRow&);
  const char* figure;  // unit and quantity of the number that the table shows, for example "°, direction"
};

const std::vector<Task>& tasks() {
  static const std::vector<Task> all{
      {"feel a smooth surface",
       {"", "", "", "slide", "direction", "rms", ""},
       {"ball", "torus"},
       error_of,
       "°, direction"},
      {"feel edges, grooves and walls",
       {"", "", "", "slide", "direction", "rms", ""},
       {"box edges", "groove", "thin sheet"},
       error_of,
       "°, direction"},
      {"feel a tooth from CT", {"", "", "", "slide", "direction", "rms", ""}, {"molar"}, error_of, "°, direction"},
      {"feel the unchanged mesh of a scan",
       {"", "", "", "slide", "direction", "rms", ""},
       {"arch", "pelvis"},
       error_of,
       "°, direction"},
      {"stick and slip with a probe",
       {"", "", "", "drag", "friction", "rms", ""},
       {"ball", "torus"},
       error_of,
       "%, friction"},
      {"drill in solid tissue",
       {"", "", "", "drill", "removal", "swept volume", ""},
       {"ball", "torus", "box edges", "groove"},
       error_of,
       "% of the volume"},
      {"drill without steps of the force",
       {"", "", "", "drill", "step, asked", "", ""},
       {"ball", "torus", "box edges", "groove"},
       error_of,
       "N a tick"},
      {"break through a wall",
       {"", "", "", "break-through", "force left", "", ""},
       {"thin sheet"},
       error_of,
       "N beyond it"},
      {"a short tick",
       {"", "", "", "slide", "tick, 99.9 %", "", ""},
       {"ball", "torus", "box edges", "groove"},
       microseconds_of,
       "µs, 99.9 %"},
      {"little memory",
       {"", "", "", "set-up", "memory", "", ""},
       {"ball", "torus", "box edges", "groove"},
       error_of,
       "MiB"}};
  return all;
}

// ns, time limit for the ticks of a contact model, for their 99.9 % quantile: half of the period at 1 kHz
constexpr double kMostTick = 500e3;

/// Returns a contact model's score in a task: the geometric mean of the measured values on the task's tissues. A
/// smaller score is better. On each tissue, the model may have been measured at several resolutions; the finest
/// resolution whose ticks meet the time limit is used. Infinite if the model fails on one of the tissues.
double score(const std::vector<ModelFigure>& figures, const Task& task, const std::string& model) {
  double sum = 0;
  for (const std::string& tissue : task.tissues) {
    double value = INFINITY;
    for (const ModelFigure& f : figures) {
      if (f.model != model || f.tissue != tissue || !answers(f, task.question)) continue;
      const bool late = std::ranges::any_of(figures, [&](const ModelFigure& other) {
        return other.model == model && other.tissue == tissue && other.motion == f.motion &&
               other.row->knob == f.row->knob && other.measure == "tick, 99.9 %" && other.row->time_ns > kMostTick;
      });
      if (!late) value = task.cell(*f.row);
    }
    if (!std::isfinite(value)) return INFINITY;
    sum += std::log(std::max(value, 1e-9));
  }
  return std::exp(sum / static_cast<double>(task.tissues.size()));
}

struct Ranked {
  std::string model;
  double score = INFINITY;
};
/// Returns the models sorted by score, the best first. Models that fail are omitted.
std::vector<Ranked> ranked(const std::vector<ModelFigure>& figures, const Task& task) {
  std::vector<Ranked> all;
  for (const std::string& model : distinct(figures, &ModelFigure::model)) {
    if (const double s = score(figures, task, model); std::isfinite(s)) all.push_back({model, s});
  }
  std::ranges::stable_sort(all, {}, &Ranked::score);
  return all;
}

std::string table_of_choice(const std::vector<ModelFigure>& figures) {
  std::string out =
      "\n## Which model for which task\n\nThe best contact model for a task has the smallest value (error, time or "
      "memory) among the models that do not fail and whose tick takes at most 500 µs (99.9 % quantile) on the task's "
      "tissues. The compared values of a task are geometric means over the tissues of the task.\n\n| task | "
      "best model | value | second | its value |\n"
      "|---|---|---|---|---|\n";
  for (const Task& task : tasks()) {
    const std::vector<Ranked> order = ranked(figures, task);
    if (order.empty()) continue;
    const auto cell = [&](std::size_t i) {
      return i < order.size() ? fmt::format("`{}` | {} {}", order[i].model, number(order[i].score), task.figure)
                              : std::string("– | ");
    };
    out += fmt::format("| {} | {} | {} |\n", task.task, cell(0), cell(1));
  }
  out += "\nThe numbers of tasks in which the models are the best are";
  const std::map<std::string, int> won = tasks_won(figures);
  for (const auto& [model, count] : won)
    out += fmt::format("{} `{}` {}", model == won.begin()->first ? "" : ",", model, count);
  const std::string used(haptics::default_contact_method()->name());
  const int own = won.contains(used) ? won.at(used) : 0;
  const bool supported = std::ranges::all_of(won, [&](const auto& entry) { return entry.second <= own; });
  out +=
      fmt::format(". The program's default model is `{}`. {}.\n", used,
                  supported ? "No other model is the best in more tasks" : "Another model is the best in more tasks");
  return out;
}

/// Returns list items that state when and where the rows were measured: one item for each run of the benchmark that
/// measured some of the tissues.
std::string measured_on(const std::string& machine) {
  std::string items;
  for (const RowOrigin& origin : origins_of(machine)) {
    items += fmt::format("- **Measured on**: {}{}.\n", origin.made,
                         origin.names.empty() ? "" : fmt::format(" ({})", fmt::join(origin.names, ", ")));
  }
  return items;
}

/// Returns a section with the values measured for other libraries. `./run peers` writes these values to `file`. Empty
/// if there is no such file.
std::string peers_section(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return {};
  const std::map<std::string, std::vector<BenchRow>> rows = stored_rows(file.string());
  const auto models = rows.find("models");
  if (models == rows.end()) return {};
  const std::vector<ModelFigure> figures = model_figures(models->second);
  std::string out = fmt::format(
      "\n## How do other libraries compare?\n\nThe sliding and drilling tests were repeated with other libraries and, "
      "in the same run, with our default model (`./run peers`, [tests/peers](../tests/peers/README.md)). All libraries "
      "use the finest voxel size. All rows are in [peers.csv]({}/{}).\n",
      file.parent_path().filename().string(), file.filename().string());
  constexpr Tabled tables[] = {
      {{"Error of the direction of the force while sliding, degree (root mean square):", "", "", "slide", "direction",
        "rms", ""},
       error_of},
      {{"Error of the magnitude of the force while sliding, % (root mean square):", "", "", "slide", "magnitude", "rms",
        ""},
       error_of},
      {{"Depth that the ball has drilled after 0.6 s, mm:", "", "", "drill", "depth", "drilled", ""}, error_of},
      {{"Removed volume that exceeds the swept volume, % of the swept volume:", "", "", "drill", "removal",
        "swept volume", ""},
       error_of},
      {{"Difference between the force and the 1 N of the drilling hand, N (root mean square):", "", "", "drill",
        "force", "of the hand", ""},
       error_of},
      {{"CPU time of a tick while sliding, 99.9 % quantile, µs:", "", "", "slide", "tick, 99.9 %", "", ""},
       microseconds_of},
      {{"CPU time of a tick while drilling, 99.9 % quantile, µs:", "", "", "drill", "tick, 99.9 %", "", ""},
       microseconds_of}};
  for (const Tabled& tabled : tables)
    out += fmt::format("\n{}\n\n{}", tabled.question.title, table_of(figures, tabled.question, tabled.cell));
  return out;
}

}  // namespace

std::vector<ModelFigure> model_figures(const std::vector<BenchRow>& rows) {
  std::vector<ModelFigure> figures;
  for (const BenchRow& row : rows) {
    const std::size_t colon = row.name.find(": ");
    if (colon == std::string::npos) continue;
    const std::size_t second = row.name.rfind(", ", colon);
    if (second == std::string::npos || second == 0) continue;
    const std::size_t first = row.name.rfind(", ", second - 1);
    if (first == std::string::npos) continue;
    figures.push_back({row.name.substr(0, first), row.name.substr(first + 2, second - first - 2),
                       row.name.substr(second + 2, colon - second - 2), row.name.substr(colon + 2), &row});
  }
  return figures;
}

std::map<std::string, int> tasks_won(const std::vector<ModelFigure>& figures) {
  std::map<std::string, int> won;
  for (const Task& task : tasks()) {
    if (const std::vector<Ranked> order = ranked(figures, task); !order.empty()) ++won[order.front().model];
  }
  return won;
}

void write_models_page(const std::filesystem::path& file, const std::vector<BenchRow>& rows,
                       const std::string& machine) {
  const std::vector<ModelFigure> figures = model_figures(rows);
  const std::string folder = file.stem().string();
  std::error_code code;
  std::filesystem::create_directories(file.parent_path() / folder, code);
  if (code) throw Error(file.string(), "", code.message(), "a place where files can be made");
  std::string page = fmt::format(
      R"(# Contact models compared

This page compares all contact models with the exact solution. The tissue, the hand and the clock are the same for all
models. The command `./run bench models` (`typodont bench models --out docs/models/rows.csv --page docs/models.md`)
creates this page. With `--tissues ball,torus`, a run measures only these tissues, so the work can be divided among
several runs. The command `typodont bench models --merge --keep FILE,FILE --page docs/models.md` joins the tables of
several runs. All numbers on this page, except the numbers of other libraries, come from [rows.csv]({0}/rows.csv),
which also contains numbers that this page does not show.

{1}- **Tissue**. The tissues are a ball of 8 mm, a torus of 8 and 3 mm, a box of 6 × 6 × 4 mm, a sheet of 0.3 mm and a
  groove of 60° that is 2 mm deep. The hand slides across the edges of the box. Three more tissues are the shipped molar
  (CT), lower arch (an open mesh) and hip socket (a mesh). All tissues have a stiffness of 1 N/mm, a specific energy of
  8 J/mm³ and a friction coefficient of 0.15.
- **Hand and clock**. The tool is a ball of 1.2 mm, and the servo rate is 1 kHz. Hands that slide, and hands that tap
  (touch the tissue briefly), follow a prescribed path regardless of the force, so all models get the same input bit for
  bit. The tests of the contact models use no friction (except in the drag test) and no damper. The drilling hand is a
  simulated mass. The motions of hands that pass through sheets, and of "hostile hands" (which move fast and at random),
  are random with the seed 1, so their errors are reproducible.
- **Exact solution**. The exact solution is the position nearest to the hand at which a ball stays outside the exact
  shape. Sequential quadratic programming in double precision computes the exact solution
  (`haptics/bench/reference_contact.h`).
- **Model force and output force**. The model force is the result of the contact model, before the servo's slew limit,
  force limit and passivity controller. The output force is the force that the servo sends to the hand. All stated
  errors of the force are errors of the model force.
- **Time**. All times of ticks are CPU times of the servo thread, and the smallest time of three passes counts for each
  tick. The values of memory and set-up time include tissue, snapshots and contact model. The set-up time of `packing`
  includes the computation of the packing, which later runs read from the cache.
- **Setting**. The setting of a contact model determines how finely the model represents the tissue. The setting is the
  voxel size for models with a field, the number of spheres for `packing`, and the number of vertices for `mesh_lod`.
  For `vertex`, the setting is the voxel size of the field from which the mesh is made. In the plots, each point is one
  setting of a contact model. The tables show the finest setting of each model. The meshes of arch and socket are used
  unchanged. Three tests use only one setting per model (0.1 mm, 10,000 spheres, 8,000 vertices), namely the tests of
  hands that escape through a wall, of a break through a wall, and of "hostile hands" (fast random motions).
)",
      folder, measured_on(machine));
  page += table_of_choice(figures);
  for (const Question& question : kPlotted) {
    const std::vector<Plot> panels = panels_of(figures, question);
    if (panels.empty()) continue;
    page += fmt::format("\n## {}\n\n{}\n\n", question.title, question.text);
    const std::string name = fmt::format("{}.svg", question.file);
    write_file_atomically(file.parent_path() / folder / name, svg_panels(panels), FileKind::kDrawing);
    page += fmt::format("![{}, against the time of a tick]({}/{})\n\n", question.y_label, folder, name);
    page += table_of(figures, question, error_of);
  }
  for (const Tabled& tabled : kTabled) {
    if (tissues_of(figures, tabled.question).empty()) continue;
    page += fmt::format("\n## {}\n\n{}\n\n", tabled.question.title, tabled.question.text);
    page += table_of(figures, tabled.question, tabled.cell);
  }
  page += peers_section(file.parent_path() / folder / "peers.csv");
  write_page(file, page);
}

}  // namespace typodont
