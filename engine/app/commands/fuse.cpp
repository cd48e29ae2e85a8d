// `typodont fuse`: replaces the crowns of an imported CBCT with those of an intraoral scan.
#include "haptics/import/fuse.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "calibration/calibration_files.h"
#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/commands/values.h"
#include "engine/app/planning/scan_fusion.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/log.h"
#include "engine/base/progress.h"
#include "engine/base/units.h"
#include "haptics/import/import.h"
#include "haptics/tissue_volume.h"

namespace typodont {

namespace {

struct FuseArguments {
  std::string volume, scan, pairs, out, preview;
  double unit_mm = 1, reach_mm = 1, blend_mm = 0.5;
  std::optional<double> voxel_mm;
  bool json = false;
};

struct Outcome {
  ScanRegistration registration;
  haptics::FuseReport fused;
  PerTissue before{}, after{};
  double voxel = 0;
  std::size_t pictures = 0;
};

nlohmann::ordered_json as_json(const Outcome& o, const FuseArguments& a, const haptics::IntraoralScan& scan) {
  const auto& [p, R] = o.registration.fine.X_DS;
  nlohmann::ordered_json j;
  j["volume"] = a.volume, j["scan"] = a.scan, j["out"] = a.out;
  j["voxel_mm"] = o.voxel / kMillimetre;
  j["repairs"] = scan.repairs();
  j["start"] = {{"pairs_used", o.registration.start.inliers.size()},
                {"pairs_set_aside", o.registration.start.outliers.size()},
                {"rms_mm", o.registration.start.fre_rms / kMillimetre}};
  nlohmann::ordered_json& fine = j["registration"];
  fine["X_CS"] = {{"translation_mm", {p.x / kMillimetre, p.y / kMillimetre, p.z / kMillimetre}},
                  {"quaternion_wxyz", {R.w, R.x, R.y, R.z}}};
  // Rows and columns 1–3 of the covariance are the rotation vector (rad), 4–6 the translation (mm).
  for (std::size_t row = 0; row < 6; ++row) {
    nlohmann::ordered_json values;
    for (std::size_t column = 0; column < 6; ++column) {
      const double unit = (row < 3 ? 1 : kMillimetre) * (column < 3 ? 1 : kMillimetre);
      values.push_back(o.registration.fine.covariance[6 * row + column] / unit);
    }
    fine["covariance"].push_back(values);
  }
  fine["predicted_error_mm"] = o.registration.fine.predicted_error / kMillimetre;
  fine["residual_median_mm"] = o.registration.fine.median / kMillimetre;
  fine["residual_95_mm"] = o.registration.fine.most_of / kMillimetre;
  fine["offset_mm"] = o.registration.fine.offset / kMillimetre;
  fine["agreement_share"] = o.registration.fine.agreement;
  fine["area_mm2"] = o.registration.fine.area / kSquareMillimetre;
  fine["rounds"] = o.registration.fine.rounds;
  j["scanned_area_mm2"] = o.fused.scanned_area / kSquareMillimetre;
  j["covered_area_mm2"] = o.fused.covered_area / kSquareMillimetre;
  j["moved_mm"] = {{"mean", o.fused.mean / kMillimetre},
                   {"median", o.fused.median_size / kMillimetre},
                   {"most", o.fused.max_size / kMillimetre}};
  j["volume_before_mm3"] = by_tissue(o.before, kCubicMillimetre);
  j["volume_mm3"] = by_tissue(o.after, kCubicMillimetre);
  return j;
}

std::string as_text(const Outcome& o, const FuseArguments& a, const haptics::IntraoralScan& scan) {
  std::string s;
  const auto line = [&](std::string_view name, std::string_view text) { s += fmt::format("{:<18}{}\n", name, text); };
  for (const std::string& repair : scan.repairs()) line("repaired", repair);
  line("start", fmt::format("{} pairs used, {} set aside, {:.2f} mm rms residual", o.registration.start.inliers.size(),
                            o.registration.start.outliers.size(), o.registration.start.fre_rms / kMillimetre));
  line("registration",
       fmt::format("± {:.3f} mm at the crowns; residual {:.3f} mm (median), {:.3f} mm (95 %)",
                   o.registration.fine.predicted_error / kMillimetre, o.registration.fine.median / kMillimetre,
                   o.registration.fine.most_of / kMillimetre));
  line("", fmt::format("{:.0f} % of the scan near the CT's teeth agree, {:.0f} mm²; the scan lies {:+.3f} mm outside",
                       100 * o.registration.fine.agreement, o.registration.fine.area / kSquareMillimetre,
                       o.registration.fine.offset / kMillimetre));
  line("crowns", fmt::format("{:.0f} mm² of {:.0f} mm² scanned", o.fused.covered_area / kSquareMillimetre,
                             o.fused.scanned_area / kSquareMillimetre));
  line("moved",
       fmt::format("by {:.3f} mm (median), {:.3f} mm (95 %), {:+.3f} mm outward on average",
                   o.fused.median_size / kMillimetre, o.fused.max_size / kMillimetre, o.fused.mean / kMillimetre));
  for (std::size_t t = 0; t < o.after.size(); ++t) {
    if (!(o.before[t] > 0 || o.after[t] > 0)) continue;
    line(name_of(static_cast<Tissue>(t)),
         fmt::format("{:.1f} mm³, before {:.1f} mm³", o.after[t] / kCubicMillimetre, o.before[t] / kCubicMillimetre));
  }
  line("result", fmt::format("{}: voxels of {:.4g} mm", a.out, o.voxel / kMillimetre));
  if (o.pictures > 0) line("preview", fmt::format("{} pictures in {}", o.pictures, a.preview));
  return s;
}

void run(const FuseArguments& a) {
  require_output(a.out, FileKind::kVolume);
  Outcome o;
  const calibration::PointPairs pairs = calibration::read_pairs(a.pairs, "s", "c");
  Progress progress("fuse");
  const haptics::IntraoralScan scan(a.scan, a.unit_mm * kMillimetre);
  const haptics::TissueVolume volume = haptics::TissueVolume::load(a.volume);
  const haptics::DenseTissue ct = dense_tissue(volume, a.volume);
  o.before = volume.volumes();
  progress.at(0.1);
  o.registration = register_scan(scan, ct, pairs.H, pairs.D, a.pairs, a.scan);
  haptics::FuseOptions options;
  if (a.voxel_mm) options.voxel = *a.voxel_mm * kMillimetre;
  options.reach = a.reach_mm * kMillimetre, options.blend = a.blend_mm * kMillimetre;
  options.progress = [&](double done) { progress.at(0.2 + 0.7 * done); };
  haptics::Fused fused = haptics::fuse(ct, scan, o.registration.fine.X_DS, options);
  const haptics::TissueVolume result(fused.tissue);
  result.save(a.out);
  o.fused = fused.report;
  o.after = result.volumes();
  o.voxel = fused.tissue.frame.voxel;
  if (!a.preview.empty()) {
    haptics::Imported shown;
    glm::ivec3 lo, hi;
    result.bounds(lo, hi);
    shown.report.lo = result.frame().to_world(dvec3(lo)) + result.band();
    shown.report.hi = result.frame().to_world(dvec3(hi)) - result.band();
    shown.tissue = std::move(fused.tissue);
    o.pictures = haptics::write_preview(shown, a.preview).size();
  }
  progress.at(1);
  fmt::print("{}", a.json ? as_json(o, a, scan).dump(2) + "\n" : as_text(o, a, scan));
}

}  // namespace

void add_fuse_command(cli::Command& app) {
  const auto a = std::make_shared<FuseArguments>();
  cli::Command* command =
      app.add_command("fuse", "Replace the crowns of a cone beam CT by the surface of an intraoral scan");
  command->add_option("VOLUME", a->volume, "the CT, from import --preset jaw (.vdb)")->required();
  command
      ->add_option("SCAN", a->scan,
                   fmt::format("intraoral scan, which may be open ({})", fmt::join(haptics::mesh_endings(), " ")))
      ->required();
  command
      ->add_option("--pairs", a->pairs,
                   "CSV: sx_mm,sy_mm,sz_mm,cx_mm,cy_mm,cz_mm (or _m): three points or more, in the scan and in the CT")
      ->required();
  command->add_option("--out", a->out, "volume to write (.vdb)", cli::writes({FileKind::kVolume}))->required();
  command->add_setting("--unit-mm", a->unit_mm, "millimetres per unit of the scan's file", cli::more_than_zero());
  command->add_option("--voxel-mm", a->voxel_mm, "voxel of the result; default: the CT's", cli::range(0.02, 2.0));
  command->add_setting("--reach-mm", a->reach_mm,
                       "largest distance between scan and CT at which the scan shows a crown", cli::range(0.1, 3.0));
  command->add_setting("--blend-mm", a->blend_mm, "width of the transition to the CT at the rim of the crowns",
                       cli::range(0.05, 5.0));
  command->add_option("--preview", a->preview, "folder for pictures of slices");
  command->add_flag("--json", a->json, "print the report as JSON");
  command->footer(
      "The pairs give the start; the fine registration lays the scan on the CT's teeth and refuses a result that it\n"
      "cannot trust. Points of the scan are in millimetres, also if --unit-mm is not 1.\n"
      "Example: typodont fuse jaw.vdb lower.ply --pairs pairs.csv --out fused.vdb --voxel-mm 0.15 --preview slices");
  command->callback([a] { run(*a); });
}

}  // namespace typodont
