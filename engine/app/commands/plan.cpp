// `typodont plan`: checks a planned implant, writes the exercise.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/commands/values.h"
#include "engine/app/planning/implant_planner.h"
#include "engine/app/planning/planned_exercise.h"
#include "engine/base/error.h"
#include "engine/base/progress.h"
#include "engine/base/units.h"
#include "engine/surface/mesh_export.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

constexpr int kPlanPixels = 480;

struct PlanOptions {
  std::string input, procedure, bone_class, out, preview, implant;
  std::vector<double> entry_mm, axis;
  double width_mm = 40;
  bool json = false;
};

/// A scene that contains only this volume.
Scene scene_of_volume(const std::string& file) {
  const nlohmann::ordered_json text = {{"name", fs::path(file).stem().string()},
                                       {"tissue", {{"volume", fs::absolute(file).string()}}},
                                       {"tool", "round_012"}};
  return parse_scene(Json::parse(text.dump(), file, Json::Lines::kUnknown), file);
}

ImplantProcedure procedure_for(const PlanOptions& options, const Scene& scene) {
  if (!options.procedure.empty()) return read_procedure(options.procedure, scene.place);
  if (const auto own = procedure_of(scene)) return *own;
  return implant_procedures().front();
}

nlohmann::ordered_json as_json(const ImplantProcedure& procedure, const session::ImplantPlan& plan,
                               const PlanFindings& found, const ImplantPlanner& planner, const PlanOptions& options) {
  const NerveCanal canal = planner.canal_near(plan);
  const Pose& X_FW = planner.volume().place().X_FW;
  nlohmann::ordered_json json = {
      {"procedure", procedure.path},
      {"implant", {{"diameter_mm", plan.diameter / kMillimetre}, {"length_mm", plan.length / kMillimetre}}},
      {"entry_mm", vec(plan.entry_W, kMillimetre)},
      {"apex_mm", vec(plan.apex_W(), kMillimetre)},
      {"axis", vec(plan.axis_W, 1)},
      {"in_file", {{"entry_mm", vec(X_FW * plan.entry_W, kMillimetre)}, {"axis", vec(X_FW.rotate(plan.axis_W), 1)}}},
      {"fits", found.fits()},
      {"in_bone_percent", 100 * found.in_bone},
      {"leaves_at_mm", nullptr},
      {"leaves_depth_mm", nullptr},
      {"canal_mm", found.canal_distance / kMillimetre},  // infinite without a canal: null
      {"canal_margin_mm", procedure.canal_margin / kMillimetre},
      {"tooth_mm", found.tooth_distance / kMillimetre},
      {"mean_grey_HU", found.mean_grey},
      {"canal", nullptr},
      {"out", options.out},
      {"preview", options.preview},
      {"implant_mesh", options.implant}};
  if (found.leaves_at_W) {
    json["leaves_at_mm"] = vec(*found.leaves_at_W, kMillimetre);
    json["leaves_depth_mm"] = found.leaves_depth / kMillimetre;
  }
  if (!canal.path_W.empty()) {
    json["canal"] = {{"diameter_mm", 2 * canal.radius / kMillimetre}};
    for (const dvec3& p : canal.path_W) json["canal"]["path_mm"].push_back(vec(p, kMillimetre));
  }
  return json;
}

/// The implant, without its thread, as a closed cylinder in mm, in the coordinates F of the imported file. `X_FW`: pose
/// of frame W in F.
surface::WholeMesh mesh_of(const session::ImplantPlan& plan, const Pose& X_FW) {
  constexpr std::uint32_t kSides = 96;
  surface::WholeMesh mesh;
  const dquat R = rotation_between({0, 0, -1}, plan.axis_W);
  const auto add = [&](const dvec3& p_W, const dvec3& normal_W) {
    mesh.vertices.push_back({glm::vec3(X_FW * p_W / kMillimetre), glm::vec3(X_FW.rotate(normal_W)), Tissue::kAmalgam});
  };
  // The vertices of the rims exist twice, because the normals of the flat ends differ.
  const auto add_rim = [&](const dvec3& middle_W, const dvec3& normal_W) {
    for (std::uint32_t i = 0; i < kSides; ++i) {
      const double a = 2 * kPi * i / kSides;
      const dvec3 out_W = R * dvec3(std::cos(a), std::sin(a), 0);
      add(middle_W + plan.diameter / 2 * out_W, normal_W == dvec3(0) ? out_W : normal_W);
    }
  };
  add_rim(plan.entry_W, dvec3(0));
  add_rim(plan.apex_W(), dvec3(0));
  add_rim(plan.entry_W, -plan.axis_W);
  add_rim(plan.apex_W(), plan.axis_W);
  add(plan.entry_W, -plan.axis_W);
  add(plan.apex_W(), plan.axis_W);
  for (std::uint32_t i = 0; i < kSides; ++i) {
    const std::uint32_t j = (i + 1) % kSides;
    mesh.triangles.push_back({i, kSides + i, kSides + j});
    mesh.triangles.push_back({i, kSides + j, j});
    mesh.triangles.push_back({4 * kSides, 2 * kSides + i, 2 * kSides + j});
    mesh.triangles.push_back({4 * kSides + 1, 3 * kSides + j, 3 * kSides + i});
  }
  return mesh;
}

/// Draws the three sections through the planned implant side by side.
render::Picture preview_of(const ImplantPlanner& planner, const session::ImplantPlan& plan, double width) {
  constexpr int n = kPlanPixels;
  const PlanPlanes planes = planner.planes(plan, width);
  render::Picture all{{n * static_cast<int>(planes.size()), n}, {}};
  all.rgba.resize(4 * static_cast<std::size_t>(all.size.x) * static_cast<std::size_t>(all.size.y));
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const render::Picture one = planner.picture(planes[i], plan, n);
    for (int y = 0; y < n; ++y)
      std::copy_n(one.at(0, y), 4 * n, all.rgba.data() + (all.at(static_cast<int>(i) * n, y) - all.rgba.data()));
  }
  return all;
}

void run(const PlanOptions& options) {
  Progress progress("plan");
  const bool volume = options.input.ends_with(".vdb");
  Scene scene = volume ? scene_of_volume(options.input) : read_scene(options.input);
  if (!options.out.empty()) require_planned_exercise(scene, options.out, Over::kNoInput);
  if (!options.bone_class.empty()) scene = with_bone_class(scene, options.bone_class);
  const ImplantPlanner planner(scene);
  progress.at(0.4);
  const ImplantProcedure procedure = procedure_for(options, scene);
  session::ImplantPlan plan = planner.proposal(procedure);
  if (!options.entry_mm.empty()) {
    plan.entry_W = dvec3(options.entry_mm[0], options.entry_mm[1], options.entry_mm[2]) * kMillimetre;
    plan.axis_W = {0, 0, -1};
  }
  if (!options.axis.empty()) {
    const dvec3 axis(options.axis[0], options.axis[1], options.axis[2]);
    if (!(glm::length(axis) > 1e-9)) throw Error("--axis", "", "0 0 0", "a direction into the bone");
    plan.axis_W = glm::normalize(axis);
  }
  const PlanFindings found = planner.findings(plan);
  progress.at(0.6);
  if (!options.preview.empty())
    render::write_png(options.preview, preview_of(planner, plan, options.width_mm * kMillimetre));
  if (!options.implant.empty())
    surface::write_mesh(options.implant, mesh_of(plan, planner.volume().place().X_FW), {dvec3(0), kMillimetre},
                        load_materials());
  progress.stage("plan", 0.7, 1);
  if (!options.out.empty())
    write_planned_exercise({fs::path(options.out).stem().string(), &planner, procedure, plan}, options.out,
                           Over::kNoInput, progress);
  progress.at(1);

  if (options.json) {
    fmt::print("{}\n", as_json(procedure, plan, found, planner, options).dump(2));
    return;
  }
  const auto mm = [](const dvec3& p) {
    return fmt::format("({:.2f}, {:.2f}, {:.2f}) mm", p.x / kMillimetre, p.y / kMillimetre, p.z / kMillimetre);
  };
  fmt::print("{}: platform {}, apex {}, axis ({:.3f}, {:.3f}, {:.3f})\n", procedure.name, mm(plan.entry_W),
             mm(plan.apex_W()), plan.axis_W.x, plan.axis_W.y, plan.axis_W.z);
  fmt::print("{:.1f} % of its thread lies in bone, with a mean grey value of {:.0f} HU\n", 100 * found.in_bone,
             found.mean_grey);
  if (found.leaves_at_W)
    fmt::print("it leaves the bone {:.1f} mm deep, at {}\n", found.leaves_depth / kMillimetre, mm(*found.leaves_at_W));
  if (std::isfinite(found.canal_distance))
    fmt::print("{:.2f} mm to the nerve canal (the procedure asks for {:.1f} mm)\n", found.canal_distance / kMillimetre,
               procedure.canal_margin / kMillimetre);
  if (std::isfinite(found.tooth_distance))
    fmt::print("{:.2f} mm to the nearest tooth\n", found.tooth_distance / kMillimetre);
  for (const std::string& file : {options.preview, options.implant, options.out})
    if (!file.empty()) fmt::print("wrote {}\n", file);
}

}  // namespace

void add_plan_command(cli::Command& app) {
  auto options = std::make_shared<PlanOptions>();
  cli::Command* command = app.add_command("plan", "Plan an implant in a jaw, and write the exercise");
  command->footer(
      "Without --entry-mm: the scene's own plan, or a proposal for a vertical implant. The result states how much of "
      "the\n"
      "implant lies in bone and its distances to nerve canal and teeth. An implant that leaves the bone is shown by\n"
      "--preview, but no exercise is written for it.\n"
      "Example:\n  typodont import cbct/ --preset jaw --out jaw.vdb\n"
      "  typodont plan jaw.vdb --entry-mm 21 12 23 --preview site.png --out site.json\n"
      "  typodont run site.json");
  command->add_option("input", options->input, "scene (JSON) or volume (.vdb) of a jaw with grey values")->required();
  command->add_option("--procedure", options->procedure,
                      "procedure file (default: the scene's, or the first of implants/procedures)");
  command->add_option("--bone-class", options->bone_class,
                      "bone of another class, I to IV (default: the scene's); for synthetic bone, not for scans");
  command->add_option("--entry-mm", options->entry_mm, "middle of the implant's platform")->expected(3);
  command->add_option("--axis", options->axis, "direction into the bone (default: the plan's, or 0 0 -1)")->expected(3);
  command->add_option("--preview", options->preview,
                      "picture to write (.png): sections across the arch, along it, and through the platform",
                      cli::writes({FileKind::kPicture}));
  command->add_option("--implant", options->implant,
                      "mesh of the planned implant to write, as a cylinder in the coordinates of the imported scan "
                      "(.stl, .ply, .obj, .glb, .gltf, .3mf)",
                      cli::writes({FileKind::kStl, FileKind::kPly, FileKind::kObj}));
  command->add_setting("--width-mm", options->width_mm, "width of each section", cli::range(5.0, 300.0));
  command->add_option("--out", options->out,
                      "exercise to write (.json); tissue from a volume is cut to the site and written beside it (.vdb)",
                      cli::writes({FileKind::kJson}));
  command->add_flag("--json", options->json, "print the result as JSON");
  command->callback([options, command] {
    command->refuse_without({"--width-mm"}, !options->preview.empty(), "--preview");
    run(*options);
  });
}

}  // namespace typodont
