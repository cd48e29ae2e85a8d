#include "engine/app/bench/models_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string_view>
#include <utility>

#include "engine/app/bench/plot.h"
#include "engine/base/error.h"
#include "engine/base/file_kind.h"
#include "engine/base/json.h"

namespace typodont {

namespace {

/// The distinct values of a member, in the order of their first appearance.
std::vector<std::string> distinct(const std::vector<ModelFigure>& figures, std::string ModelFigure::*member) {
  std::vector<std::string> all;
  for (const ModelFigure& f : figures)
    if (std::find(all.begin(), all.end(), f.*member) == all.end()) all.push_back(f.*member);
  return all;
}

/// A measure on a motion. `unit` chooses among rows of one measure: the end of their unit.
struct Question {
  const char *title, *text, *file;
  const char *motion, *measure, *unit;
  const char* y_label;
};

constexpr Question kPlotted[] = {
    {"Is the direction right?",
     "The hand slides over the tissue with 20 mm/s, 0.3 mm ahead of where the tissue holds the ball. Angle between the "
     "force that the model asks for and the exact one.",
     "direction", "slide", "direction", "rms", "direction error, degree rms"},
    {"Is the magnitude right?", "The same slide: by how much the force's size is off.", "magnitude", "slide",
     "magnitude", "rms", "magnitude error, % rms"},
    {"Is the tool drawn inside the tissue?",
     "The same slide: how deep the tool as it is drawn lies in the exact shape, at most.", "penetration", "slide",
     "penetration", "greatest", "penetration, mm"},
    {"Is what was removed what the bur swept?",
     "A round bur of 1.2 mm in a hand of 0.15 kg that pushes with 1 N and swings to and fro. The volume that the "
     "tissue "
     "lost, against the volume inside the exact shape that the bur's cuts swept, counted on a grid of 0.02 mm.",
     "removal", "drill", "removal", "swept volume", "removal error, % of the swept volume"}};

bool answers(const ModelFigure& f, const Question& q) {
  return f.motion == q.motion && f.measure == q.measure && f.row->error_unit.ends_with(q.unit);
}

std::vector<Plot> panels_of(const std::vector<ModelFigure>& figures, const Question& q) {
  const std::vector<std::string> models = distinct(figures, &ModelFigure::model);
  std::vector<Plot> panels;
  for (const std::string& tissue : distinct(figures, &ModelFigure::tissue)) {
    Plot plot{tissue, "servo's tick, median, ns", q.y_label, {}};
    for (const std::string& model : models) plot.of(model);  // the same colour in every panel
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

/// What a table cell shows of a row.
using CellOf = std::function<double(const BenchRow&)>;
double error_of(const BenchRow& row) {
  return row.error;
}
double microseconds_of(const BenchRow& row) {
  return row.time_ns * 1e-3;
}

/// The finest setting that was measured of each model: its last knob.
std::string finest_knob(const std::vector<ModelFigure>& figures, const std::string& model) {
  std::string knob;
  for (const ModelFigure& f : figures)
    if (f.model == model) knob = f.row->knob;
  return knob;
}

/// Models in rows, tissues in columns; each model by its finest setting.
std::string table_of(const std::vector<ModelFigure>& figures, const Question& q, const CellOf& cell) {
  std::vector<std::string> tissues;
  for (const std::string& tissue : distinct(figures, &ModelFigure::tissue)) {
    if (std::any_of(figures.begin(), figures.end(),
                    [&](const ModelFigure& f) { return f.tissue == tissue && answers(f, q); }))
      tissues.push_back(tissue);
  }
  std::string out = "| model | setting |";
  std::string line = "|---|---|";
  for (const std::string& tissue : tissues) out += fmt::format(" {} |", tissue), line += "---|";
  out += "\n" + line + "\n";
  for (const std::string& model : distinct(figures, &ModelFigure::model)) {
    const std::string knob = finest_knob(figures, model);
    out += fmt::format("| `{}` | {} |", model, knob);
    for (const std::string& tissue : tissues) {
      double value = BenchRow::kNone;
      for (const ModelFigure& f : figures)
        if (f.model == model && f.tissue == tissue && f.row->knob == knob && answers(f, q)) value = cell(*f.row);
      out += fmt::format(" {} |", number(value));
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
    {{"What does a tick cost, at worst?", "Thread processor time of the servo's tick while sliding: 99.9 %, µs.", "",
      "slide", "tick, 99.9 %", "", ""},
     microseconds_of},
    {{"And while drilling?", "The same while the bur cuts: 99.9 %, µs.", "", "drill", "tick, 99.9 %", "", ""},
     microseconds_of},
    {{"What does a cut cost the carver?", "The other thread's work for one cut, median, µs.", "", "drill",
      "carver's cut, median", "", ""},
     microseconds_of},
    {{"How large is the largest step of the force, as the model asks for it?",
      "Sliding; N in a tick, beyond the step of the exact force.", "", "slide", "step, asked", "", ""},
     error_of},
    {{"And as the hand feels it?", "The same behind the servo's slew, limits and energy ledger.", "", "slide",
      "step, felt", "", ""},
     error_of},
    {{"How much energy does a tap give, as the model asks for it?",
      "Taps with 10, 30, 100 and 200 mm/s, 0.3 mm deep: µJ given to the hand, at most.", "", "tap",
      "energy given, asked", "", ""},
     error_of},
    {{"And as the hand feels it?", "The same behind the energy ledger.", "", "tap", "energy given, felt", "", ""},
     error_of},
    {{"What does it take to set up?", "Memory of tissue, snapshots and model, MiB.", "", "set-up", "memory", "", ""},
     error_of},
    {{"And how long?", "Processor time of all threads, s.", "", "set-up", "time", "", ""}, error_of}};

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

void write_models_page(const std::filesystem::path& file, const std::vector<BenchRow>& rows,
                       const std::string& machine) {
  const std::vector<ModelFigure> figures = model_figures(rows);
  const std::string folder = file.stem().string();
  std::error_code code;
  std::filesystem::create_directories(file.parent_path() / folder, code);
  if (code) throw Error(file.string(), "", code.message(), "a place where files can be made");
  std::string page = fmt::format(
      R"(# Contact models compared

Every contact model of the program on the same tissue, with the same hand and the same clock, against the exact answer.
Made by `typodont bench models --out docs/models/rows.csv --page docs/models.md`; not typed by hand. Every figure is a
row of [rows.csv]({0}/rows.csv), which has also those that are not shown here.

- **Measured on**: {1}.
- **Tissue**: ball of 8 mm; torus of 8 and 3 mm; box of 6 × 6 × 4 mm whose edges are crossed; sheet of 0.3 mm; groove of
  60°, 2 mm deep. Stiffness 1 N/mm, specific energy 8 J/mm³.
- **Hand and clock**: a ball of 1.2 mm, 1 kHz. Sliding and tapping hands go where they are told, whatever they feel, so
  all models get the same input to the bit; no friction, no damper. The drilling hand is a simulated mass. Nothing is
  random: a run gives the same errors again.
- **Truth**: where a ball comes to rest that must stay outside the exact shape, nearest to the hand, found by sequential
  quadratic programming in double precision (`haptics/bench/reference_contact.h`).
- **Asked and felt**: the force that the model asks for, before the servo's slew, limits and energy ledger; and the force
  that the hand feels, behind them. Errors are those of the force asked for.
- **Time**: processor time of the servo's thread, the least of three passes for each tick. Memory and set-up are those of
  tissue, snapshots and model together.
- **Knobs**: field models by the voxel, `packing` by the number of spheres, `mesh_lod` by the number of vertices, `vertex`
  by the voxel of the field that its mesh is made from. In plots each point is one setting; tables show the finest.
)",
      folder, machine);
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
    page += fmt::format("\n## {}\n\n{}\n\n", tabled.question.title, tabled.question.text);
    page += table_of(figures, tabled.question, tabled.cell);
  }
  write_file_atomically(file, page);
}

}  // namespace typodont
