// `typodont import`: converts scans or meshes to a volume (.vdb) or a scene (.json).
#include "haptics/import/import.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/commands/values.h"
#include "engine/app/planning/imported_exercise.h"
#include "engine/app/planning/mouth.h"
#include "engine/app/planning/volume_beside.h"
#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/log.h"
#include "engine/base/progress.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/import/volume_export.h"
#include "haptics/tissue_volume.h"

namespace typodont {

namespace {

struct ImportArguments {
  std::string out, bite, preset = "tooth", spacing, thresholds, hardness, colors, preview, turn, labels, region;
  std::vector<std::string> inputs, parts, label;
  std::optional<int> series;
  std::optional<double> voxel_mm, shell_mm, hounsfield, nan_grey, memory_mb, crown_mm;
  double band_mm = 1.5, unit_mm = 1, open_mm = 0;
  bool json = false;
};

haptics::ImportOptions options_of(const ImportArguments& a) {
  haptics::ImportOptions o;
  o.preset = a.preset == "bone"   ? haptics::ImportPreset::kBone
             : a.preset == "arch" ? haptics::ImportPreset::kArch
             : a.preset == "jaw"  ? haptics::ImportPreset::kJaw
                                  : haptics::ImportPreset::kTooth;
  if (a.crown_mm) o.crown = *a.crown_mm * kMillimetre;
  if (a.voxel_mm) o.voxel = *a.voxel_mm * kMillimetre;
  if (a.shell_mm) o.shell = *a.shell_mm * kMillimetre;
  o.band = a.band_mm * kMillimetre;
  o.mesh_unit = a.unit_mm * kMillimetre;
  if (!a.spacing.empty()) {
    auto mm = numbers(a.spacing, "--spacing-mm", 1, 3, "one or three millimetres, e.g. 0.134,0.134,0.134");
    if (mm.size() == 1) mm = {mm[0], mm[0], mm[0]};
    if (mm.size() != 3) throw Error("--spacing-mm", "", a.spacing, "one or three millimetres, e.g. 0.134,0.134,0.134");
    o.spacing = dvec3(mm[0], mm[1], mm[2]) * kMillimetre;
  }
  if (!a.thresholds.empty()) {
    const char* expected = "SURFACE or SURFACE,DENSE: one or two rising greys, e.g. 614,1013";
    const auto t = numbers(a.thresholds, "--thresholds", 1, 2, expected);
    if (t.size() == 2 && t[1] <= t[0]) throw Error("--thresholds", "", '"' + a.thresholds + '"', expected);
    o.surface_grey = t[0];
    if (t.size() == 2) o.dense_grey = t[1];
  }
  if (!a.region.empty()) {
    const char* expected = "X0,Y0,Z0,X1,Y1,Z1: two corners in mm, the first the lower one";
    const auto mm = numbers(a.region, "--region-mm", 6, 6, expected);
    o.region = {dvec3(mm[0], mm[1], mm[2]) * kMillimetre, dvec3(mm[3], mm[4], mm[5]) * kMillimetre};
    if (!glm::all(glm::lessThan(o.region->lo, o.region->hi)))
      throw Error("--region-mm", "", '"' + a.region + '"', expected);
  }
  o.hounsfield = a.hounsfield;
  o.series = a.series;
  o.greys = !a.preview.empty() || !a.colors.empty();
  if (a.memory_mb) o.memory = *a.memory_mb * 1e6;
  o.estimated = [](double bytes) { log::info("about {:.0f} MB of memory are needed", bytes * 1e-6); };
  o.nan_grey = a.nan_grey;
  if (!a.turn.empty()) o.turn = haptics::quarter_turns(a.turn);
  for (const std::string& part : a.parts) {
    const std::size_t equals = part.find('=');
    const auto tissue = equals == std::string::npos ? std::nullopt : tissue_named(part.substr(0, equals));
    if (!tissue || *tissue == Tissue::kAir || equals + 1 == part.size())
      throw Error("--part", "", '"' + part + '"', "TISSUE=FILE, e.g. enamel=enamel.stl");
    o.parts.push_back({*tissue, part.substr(equals + 1)});
  }
  for (const std::string& label : a.label) {
    int value = 0;
    const std::size_t equals = std::min(label.find('='), label.size());
    const auto [end, error] = std::from_chars(label.data(), label.data() + equals, value);
    const auto tissue = equals < label.size() ? tissue_named(label.substr(equals + 1)) : std::nullopt;
    if (error != std::errc() || end != label.data() + equals || value < 1 || value > 65535 || !tissue ||
        !o.labels.emplace(value, *tissue).second)
      throw Error("--label", "", '"' + label + '"',
                  "VALUE=TISSUE, once for each value above 0, e.g. 1=enamel or 7=air");
  }
  if (!a.hardness.empty()) {
    const char* expected = "ZERO,OWN or ZERO,OWN,DENSE: greys, the first the least, e.g. 400,830,1190";
    const auto greys = numbers(a.hardness, "--hardness-greys", 2, 3, expected);
    if (greys[1] <= greys[0] || greys.back() <= greys[0])
      throw Error("--hardness-greys", "", '"' + a.hardness + '"', expected);
    o.hardness = {greys[0], greys[1], std::nullopt};
    if (greys.size() == 3) o.hardness->dense = greys[2];
  }
  return o;
}

bool has_greys(const haptics::ImportReport& r) {
  return r.spacing != dvec3(0) && !r.format.ends_with("label map");
}

nlohmann::ordered_json as_json(const haptics::ImportReport& r, const ImportArguments& a,
                               const std::vector<std::filesystem::path>& pictures) {
  nlohmann::ordered_json j;
  // The name of a DICOM folder is left out, because it often contains a patient's name.
  if (a.inputs.size() == 1) j["input"] = r.format == "DICOM" ? r.format : a.inputs[0];
  if (a.inputs.size() > 1) j["inputs"] = a.inputs;
  if (!a.bite.empty()) j["bite"] = a.bite;
  for (const std::string& part : a.parts) j["parts"].push_back(part);
  j["out"] = a.out;
  j["format"] = r.format;
  j["preset"] = a.preset;
  if (r.spacing != dvec3(0)) j["spacing_mm"] = vec(r.spacing, kMillimetre);
  j["voxel_mm"] = r.voxel / kMillimetre;
  j["band_mm"] = a.band_mm;
  j["size"] = {r.size.x, r.size.y, r.size.z};
  j["bounds_mm"] = {vec(r.lo, kMillimetre), vec(r.hi, kMillimetre)};
  j["height_mm"] = r.height / kMillimetre;
  j["volume_mm3"] = by_tissue(r.volume, kCubicMillimetre);
  j["volume_mm3"]["total"] = std::accumulate(r.volume.begin(), r.volume.end(), 0.0) / kCubicMillimetre;
  const nlohmann::ordered_json doubt = by_tissue(r.volume_uncertainty, kCubicMillimetre);
  if (!doubt.empty()) j["volume_doubt_mm3"] = doubt;
  if (r.jaw || !a.hardness.empty()) j["mean_hardness"] = by_tissue(r.hardness, 1);
  if (r.false_dentin) j["crown_false_dentin_share"] = *r.false_dentin;
  j["components_found"] = r.bodies_found;
  j["components_kept"] = r.bodies_kept;
  j["pulp_parts"] = r.pulp_parts;
  if (has_greys(r)) {
    j["greys"] = {{"outside", r.outside_grey}, {"soft", r.soft_grey}, {"noise", r.noise_grey}};
    j["thresholds"] = {{"surface", r.surface_grey}};
    if (r.dense_level) j["greys"]["dense"] = *r.dense_level;
    if (r.dense_grey) j["thresholds"]["dense"] = *r.dense_grey;
    j["blur_mm"] = r.blur / kMillimetre;
  }
  if (r.jaw) {
    nlohmann::ordered_json& jaw = j["jaw"];
    jaw["crowns"] = r.jaw->crowns();
    jaw["teeth"] = nlohmann::ordered_json::array();
    for (const haptics::JawTooth& tooth : r.jaw->teeth)
      jaw["teeth"].push_back(
          {{"centre_mm", vec(tooth.centre, kMillimetre)}, {"volume_mm3", tooth.volume / kCubicMillimetre}});
    jaw["border_mm"] = r.jaw->border / kMillimetre;
    jaw["unsure_mm3"] = r.jaw->mislabelled / kCubicMillimetre;
    // Repeats the value "volume_doubt_mm3" inside "jaw", where other programs read it.
    if (!doubt.empty()) jaw["volume_doubt_mm3"] = doubt;
    jaw["canals"] = nlohmann::ordered_json::array();
    for (const haptics::JawCanal& canal : r.jaw->canals) {
      nlohmann::ordered_json of_canal;
      of_canal["doubt_mm"] = canal.uncertainty / kMillimetre;
      for (const dvec3& p : canal.centre) of_canal["centre_mm"].push_back(vec(p, kMillimetre));
      jaw["canals"].push_back(of_canal);
    }
  }
  if (!a.labels.empty()) j["labels"] = a.labels;
  j["memory_mb"] = r.memory * 1e-6;
  if (!r.space.empty()) j["space"] = r.space;
  for (int row = 0; row < 3; ++row)
    j["world_rotation"].push_back({r.world_rotation[0][row], r.world_rotation[1][row], r.world_rotation[2][row]});
  j["repairs"] = r.repairs;
  j["notes"] = r.notes;
  j["preview"] = nlohmann::ordered_json::array();
  for (const auto& p : pictures) j["preview"].push_back(p.string());
  return j;
}

std::string as_text(const haptics::ImportReport& r, const ImportArguments& a,
                    const std::vector<std::filesystem::path>& pictures) {
  std::string s;
  const auto line = [&](std::string_view name, std::string_view text) { s += fmt::format("{:<22}{}\n", name, text); };
  const dvec3 extent = (r.hi - r.lo) / kMillimetre;
  if (r.spacing != dvec3(0)) {
    line("scan", fmt::format("{}, {:.4g} x {:.4g} x {:.4g} mm a voxel", r.format, r.spacing.x / kMillimetre,
                             r.spacing.y / kMillimetre, r.spacing.z / kMillimetre));
  }
  if (has_greys(r)) {
    line("greys", fmt::format("surround {:.4g} ± {:.2g}, {} {:.4g}{}", r.outside_grey, r.noise_grey,
                              a.preset == "tooth" ? "dentin"
                              : r.jaw             ? "cancellous bone"
                                                  : "bone",
                              r.soft_grey,
                              r.dense_level ? fmt::format(", {} {:.4g}",
                                                          a.preset == "tooth" ? "enamel"
                                                          : r.jaw             ? "enamel or metal"
                                                                              : "cortical bone",
                                                          *r.dense_level)
                                            : ""));
    if (!r.jaw)
      line("thresholds", fmt::format("surface {:.4g} (refined from the greys near by){}", r.surface_grey,
                                     r.dense_grey ? fmt::format(", denser tissue {:.4g}", *r.dense_grey) : ""));
    line("edge blur", fmt::format("{:.3f} mm", r.blur / kMillimetre));
  }
  if (r.spacing == dvec3(0)) line("mesh", r.format);
  line("components", fmt::format("{} found, {} kept", r.bodies_found, r.bodies_kept));
  line("size", fmt::format("{:.2f} x {:.2f} x {:.2f} mm, height {:.2f} mm", extent.x, extent.y, extent.z,
                           r.height / kMillimetre));
  line("at", fmt::format("({:.2f}, {:.2f}, {:.2f}) to ({:.2f}, {:.2f}, {:.2f}) mm", r.lo.x / kMillimetre,
                         r.lo.y / kMillimetre, r.lo.z / kMillimetre, r.hi.x / kMillimetre, r.hi.y / kMillimetre,
                         r.hi.z / kMillimetre));
  for (int t = 0; t < kTissueCount; ++t) {
    const double mm3 = r.volume[static_cast<std::size_t>(t)] / kCubicMillimetre;
    const std::string hardness = a.hardness.empty() && !r.jaw
                                     ? ""
                                     : fmt::format(", mean hardness {:.2f}", r.hardness[static_cast<std::size_t>(t)]);
    const double doubt = r.volume_uncertainty[static_cast<std::size_t>(t)] / kCubicMillimetre;
    const std::string uncertainty = doubt > 0 ? fmt::format(" ± {:.1f}", doubt) : "";
    if (mm3 > 0) line(name_of(static_cast<Tissue>(t)), fmt::format("{:.1f}{} mm³{}", mm3, uncertainty, hardness));
  }
  if (r.jaw) {
    line("crowns", fmt::format("{}", r.jaw->crowns()));
    line("borders", fmt::format("± {:.2f} mm; {:.1f} mm³ may be tooth or bone", r.jaw->border / kMillimetre,
                                r.jaw->mislabelled / kCubicMillimetre));
    for (const haptics::JawCanal& canal : r.jaw->canals) {
      const dvec3 from = canal.centre.front() / kMillimetre, to = canal.centre.back() / kMillimetre;
      line("canal", fmt::format("({:.1f}, {:.1f}, {:.1f}) to ({:.1f}, {:.1f}, {:.1f}) mm, ± {:.2f} mm", from.x, from.y,
                                from.z, to.x, to.y, to.z, canal.uncertainty / kMillimetre));
    }
    if (r.jaw->canals.empty()) line("canal", "none found");
  }
  if (r.pulp_parts > 0 && a.preset == "tooth") line("pulp parts", fmt::format("{}", r.pulp_parts));
  if (r.false_dentin) line("false dentin on crown", fmt::format("{:.2f} %", 100 * *r.false_dentin));
  line("result",
       fmt::format("{}: {} x {} x {} voxels of {:.4g} mm", a.out, r.size.x, r.size.y, r.size.z, r.voxel / kMillimetre));
  for (const std::string& repair : r.repairs) line("repaired", repair);
  if (!a.labels.empty()) line("labels", a.labels);
  if (!pictures.empty()) line("preview", fmt::format("{} pictures in {}", pictures.size(), a.preview));
  return s;
}

nlohmann::ordered_json as_json(const MouthScan& scan) {
  const auto& [p, R] = scan.X_WK;
  nlohmann::ordered_json j;
  j["X_WK"] = {{"translation_mm", vec(p, kMillimetre)}, {"quaternion_wxyz", {R.w, R.x, R.y, R.z}}};
  if (!scan.fit) return j;
  j["moved_mm"] = scan.moved / kMillimetre;
  j["bite"] = {{"residual_median_mm", scan.fit->median / kMillimetre},
               {"residual_95_mm", scan.fit->most_of / kMillimetre},
               {"predicted_error_mm", scan.fit->predicted_error / kMillimetre},
               {"area_mm2", scan.fit->area / kSquareMillimetre}};
  return j;
}

/// Grey value of a voxel. Blur darkens the outermost voxels of the tissue, so such a voxel gets the largest grey value
/// that its tissue has near it.
double grey_of(const haptics::Imported& imported, const glm::ivec3& at) {
  constexpr int kBlur = 2;  // voxels
  const haptics::DenseTissue& t = imported.tissue;
  const std::size_t i = t.at(at.x, at.y, at.z);
  double grey = static_cast<double>(imported.grey[i]);
  if (static_cast<double>(t.distance[i]) < -kBlur * t.frame.voxel) return grey;
  const glm::ivec3 lo = glm::max(at - kBlur, glm::ivec3(0)), hi = glm::min(at + kBlur, t.size - 1);
  for_each_voxel_between(lo, hi, [&](int x, int y, int z) {
    if (const std::size_t near = t.at(x, y, z); t.tissue[near] == t.tissue[i])
      grey = std::max(grey, static_cast<double>(imported.grey[near]));
  });
  return grey;
}

/// Colours each voxel by its grey value, from brown at greys[0] to ivory at greys[1].
void color_by_greys(haptics::Imported& imported, const std::vector<double>& greys) {
  constexpr dvec3 kBrown(0.33, 0.20, 0.10), kIvory(0.96, 0.92, 0.83);  // sRGB
  haptics::DenseTissue& t = imported.tissue;
  t.color.resize(t.tissue.size());
  for_each_voxel(t.size, [&](int x, int y, int z) {
    const std::size_t i = t.at(x, y, z);
    if (t.tissue[i] == Tissue::kAir) return;
    const double part = (grey_of(imported, {x, y, z}) - greys[0]) / (greys[1] - greys[0]);
    t.color[i] = voxel_color(glm::mix(kBrown, kIvory, std::clamp(part, 0.0, 1.0)));
  });
}

bool several(const ImportArguments& a) {
  return a.inputs.size() > 1 || !a.bite.empty() || a.open_mm != 0;
}

void run(const ImportArguments& a) {
  haptics::ImportOptions options = options_of(a);
  // Checks the arguments before the long work.
  if (a.inputs.empty() == a.parts.empty())
    throw Error("INPUT", "", a.inputs.empty() ? "nothing to import" : "both INPUT and --part",
                "a scan or a mesh, or one mesh per tissue (--part TISSUE=FILE)");
  for (const std::string& input : a.inputs) {
    std::error_code code;
    if (!std::filesystem::is_directory(input, code)) require_input(input, InputKind::kScan);
    if (several(a) && !haptics::is_mesh_file(input))
      throw Error("INPUT", "", input,
                  fmt::format("several files only if all are meshes ({})", fmt::join(haptics::mesh_endings(), " ")));
  }
  if (!a.bite.empty()) require_input(a.bite, InputKind::kScan);
  const char* const rising = "DARK,LIGHT: two rising greys, e.g. 600,1600";
  const auto colors = a.colors.empty() ? std::vector<double>() : numbers(a.colors, "--color-greys", 2, 2, rising);
  if (!colors.empty() && colors[1] <= colors[0]) throw Error("--color-greys", "", '"' + a.colors + '"', rising);
  const bool exercise = kind_of_name(a.out) == FileKind::kJson;
  require_output(a.out, exercise ? FileKind::kJson : FileKind::kVolume);
  if (exercise) require_volume_beside(a.out, Over::kNoInput);
  Progress progress("import");
  options.progress = [&](double done) { progress.at(0.9 * done); };
  ImportedMouth mouth;
  if (several(a)) {
    const std::optional<std::filesystem::path> bite = a.bite.empty() ? std::nullopt : std::optional(a.bite);
    mouth = import_mouth({{a.inputs.begin(), a.inputs.end()}, bite, a.open_mm * kMillimetre}, options);
  } else {
    mouth.imported = haptics::import_tissue(a.inputs.empty() ? "" : a.inputs[0], options);
  }
  haptics::Imported& imported = mouth.imported;
  if (!colors.empty() && !has_greys(imported.report))
    throw Error("--color-greys", "", imported.report.format, "a scan with greys");
  if (!colors.empty()) color_by_greys(imported, colors);
  if (!a.labels.empty()) haptics::write_labels(imported.tissue, a.labels);
  if (exercise) {
    // Without a requested rotation, the first scan is turned upright.
    ImportedExercise written{.name = std::filesystem::path(a.out).stem().string(),
                             .description = imported.report.format == "DICOM" ? "DICOM" : ""};
    for (const std::string& input : imported.report.format == "DICOM" ? std::vector<std::string>{} : a.inputs)
      written.description +=
          (written.description.empty() ? "" : ", ") + std::filesystem::path(input).filename().string();
    if (mouth.up != dvec3(0)) {
      written.top = mouth.top;
      if (a.turn.empty()) written.crown = crown_along(mouth.up);
    }
    write_imported_exercise(written, imported, a.out, Over::kNoInput, progress);
  } else {
    haptics::TissueVolume(imported.tissue).save(a.out);
  }
  std::vector<std::filesystem::path> pictures;
  if (!a.preview.empty()) pictures = haptics::write_preview(imported, a.preview);
  progress.at(1);
  for (const std::string& note : imported.report.notes) log::info("note: {}", note);
  if (!a.json) return fmt::print("{}", as_text(imported.report, a, pictures));
  nlohmann::ordered_json report = as_json(imported.report, a, pictures);
  for (const MouthScan& scan : mouth.scans) report["scans"].push_back(as_json(scan));
  if (!mouth.scans.empty()) report["overlap_mm3"] = imported.report.overlap / kCubicMillimetre;
  fmt::print("{}\n", report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

}  // namespace

void add_import_command(cli::Command& app) {
  const auto a = std::make_shared<ImportArguments>();
  cli::Command* command = app.add_command("import", "Make a tissue volume (.vdb) from a scan or a closed mesh");
  command->add_option("INPUT", a->inputs,
                      fmt::format("scan ({}), folder of DICOM files, or closed mesh ({}); several meshes of one mouth "
                                  "become one tissue, the first is drilled",
                                  fmt::join(haptics::scan_endings(), " "), fmt::join(haptics::mesh_endings(), " ")));
  command
      ->add_option("--out", a->out, "volume to write (.vdb), or scene for practice (.json) with its volume beside it",
                   cli::writes({FileKind::kVolume, FileKind::kJson}))
      ->required();
  command->add_setting(
      "--preset", a->preset,
      "what is in it; jaw: a CBCT's bone, teeth, nerve canals and metal; arch: an intraoral scan's open mesh",
      cli::one_of({"tooth", "bone", "jaw", "arch"}));
  command->add_option("--series", a->series, "of several in DICOM files, as the message without it numbers them");
  command->add_option("--voxel-mm", a->voxel_mm,
                      "voxel of the result; default: the scan's smallest (a mesh: 0.1, a large one: more)");
  command->add_option("--spacing-mm", a->spacing,
                      "X,Y,Z: the scan's true voxel, instead of the file's; one number for all three");
  command->add_option("--region-mm", a->region,
                      "X0,Y0,Z0,X1,Y1,Z1: two corners of the part of a scan that is imported, in the scan's own "
                      "coordinates (bounds_mm of the report); default: all of it");
  command->add_option("--thresholds", a->thresholds,
                      "SURFACE[,DENSE]: greys between surround and softer tissue, and between softer and denser; "
                      "default: from the histogram");
  command->add_option("--hardness-greys", a->hardness,
                      "ZERO,OWN[,DENSE]: hardness from a scan's greys, linear from 0 at ZERO to 1 at OWN in the softer "
                      "tissue and at DENSE in the denser; default: every tissue has its own");
  command->add_option("--color-greys", a->colors,
                      "DARK,LIGHT: colour of each voxel from a scan's greys, from brown at DARK to ivory at LIGHT; "
                      "default: the colour of its tissue");
  command->add_option(
      "--hounsfield", a->hounsfield,
      "the greys are Hounsfield units plus this (0, 1024 …); default: from the histogram, with --preset "
      "bone");
  command->add_option("--nan-as", a->nan_grey, "grey that stands for voxels that are no number; default: an error");
  command->add_option("--turn", a->turn, "quarter turns of the result about its axes, e.g. x180 or x90,z-90");
  command->add_option(
      "--part", a->parts,
      "TISSUE=FILE: a closed mesh of one tissue, instead of INPUT; once for each, from the outermost to "
      "the innermost (where they overlap the later one counts)");
  command->add_option("--label", a->label,
                      "VALUE=TISSUE: what a value of a label map is, air to leave it out; once for each that the file "
                      "does not name");
  command->add_setting("--band-mm", a->band_mm, "how far from the surface distances are kept");
  command->add_setting("--unit-mm", a->unit_mm, "a mesh: millimetres per unit of its file");
  command->add_option("--shell-mm", a->shell_mm, "a mesh: thickness of enamel (default 1.3) or cortical bone (1.5)");
  command->add_option("--crown-mm", a->crown_mm,
                      "an arch without colours: how far below its cusps the gum begins (default 7)");
  command->add_option("--bite", a->bite,
                      "intraoral scan of the closed bite, which places the scans of the jaws relative to each other");
  command->add_option("--open-mm", a->open_mm, "how far the opposing scans are moved away from the first one",
                      cli::range(0.0, 60.0));
  command->add_option("--memory-mb", a->memory_mb, "memory that the work may take; default: what is free",
                      cli::more_than_zero());
  command->add_option(
      "--labels", a->labels,
      "also write the tissues as a label map (.nrrd, .nii, or .dcm: a DICOM segmentation) in the scan's "
      "own space, for 3D Slicer and others",
      cli::writes({FileKind::kLabels}));
  command->add_option("--preview", a->preview, "folder for pictures of slices");
  command->add_flag("--json", a->json, "print the report as JSON");
  command->footer(
      "Example: typodont import tooth.nhdr --preset tooth --spacing-mm 0.134 --out molar.vdb --preview slices");
  command->callback([a, command] {
    const auto& meshes = haptics::mesh_endings();
    const bool mesh = !a->inputs.empty() && haptics::is_mesh_file(a->inputs[0]);
    command->refuse_without({"--unit-mm"}, mesh || !a->parts.empty(),
                            fmt::format("a mesh ({})", fmt::join(meshes, " ")));
    command->refuse_without({"--bite", "--open-mm"}, a->preset == "arch", "--preset arch");
    command->refuse_without({"--crown-mm"}, a->preset == "arch", "--preset arch");
    command->refuse_without({"--thresholds", "--hardness-greys"}, a->preset != "jaw",
                            "another --preset than jaw, whose greys are found");
    command->refuse_without({"--shell-mm"}, mesh, fmt::format("a mesh ({})", fmt::join(meshes, " ")));
    command->refuse_without({"--spacing-mm", "--region-mm", "--thresholds", "--color-greys", "--hounsfield", "--nan-as",
                             "--series", "--label"},
                            !mesh && a->parts.empty(), "a scan");
    run(*a);
  });
}

}  // namespace typodont
