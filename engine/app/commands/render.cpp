// `typodont render`: draws a scene as each eye sees it, without a screen, and writes the eyes' matrices.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "engine/app/assets.h"
#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/commands/values.h"
#include "engine/app/operator/library.h"
#include "engine/app/picture/eye_size.h"
#include "engine/app/picture/hud.h"
#include "engine/app/picture/magnify.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/shown_geometry.h"
#include "engine/app/picture/teaching_views.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording/resume.h"
#include "engine/app/review/player.h"
#include "engine/app/scene.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/task/task.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "engine/base/folder.h"
#include "engine/base/log.h"
#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "engine/render/look.h"
#include "engine/render/shared.h"
#include "engine/session/place.h"
#include "haptics/carver.h"
#include "haptics/packing.h"
#include "haptics/scripted_hand.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

struct RenderOptions {
  std::string scene, rig, out, size, eye = "both", pose, quality = "high";
  std::string view = "look", plane, ideal, volume, language;
  double at = 0, magnify = 0;
  bool json = false, hud = false, validate = false, geometry = false, finished = false;
};

/// Parses a plane "NX,NY,NZ,OFFSET_MM": a normal and an offset. The renderer keeps the tissue with normal · p > offset.
glm::dvec4 parse_plane(const std::string& text) {
  constexpr const char* kExpected = "NX,NY,NZ,OFFSET_MM: a normal and where the plane lies";
  const std::vector<double> p = numbers(text, "--plane", 4, 4, kExpected);
  const dvec3 normal(p[0], p[1], p[2]);
  const double length = glm::length(normal);
  if (length < 1e-9) throw Error("--plane", "", '"' + text + '"', kExpected);
  return {normal / length, -p[3] * kMillimetre / length};
}

/// The plane of a section if the user names none: vertical, facing the viewer, through the tissue's middle. If the
/// scene states the tooth's sides, the plane contains the tooth's axis and one of its sides, and cuts as much pulp as
/// possible.
glm::dvec4 usual_plane(const Scene& scene, const haptics::TissueVolume& volume, const dvec3& eye_W) {
  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  const dvec3 middle = volume.frame().to_world(0.5 * dvec3(lo + hi));
  const auto sides = session::tooth_sides(Json::parse(scene.text, scene.file.string()));
  if (!sides) return section_facing(middle, eye_W);
  const dvec3 away = middle - eye_W;
  const double mesial = glm::dot(sides->mesial_W, away), buccal = glm::dot(sides->buccal_W, away);
  const dvec3 side = std::abs(buccal) > std::abs(mesial) ? sides->buccal_W : sides->mesial_W;
  const dvec3 n = glm::dot(side, away) < 0 ? -side : side;
  std::map<long, std::size_t> pulp;  // samples of pulp by the offset of their plane, in voxels
  const DenseCopy copy = dense_copy(volume);
  for_each_voxel(copy.field.size, [&](int x, int y, int z) {
    const std::size_t i = copy.field.at(x, y, z);
    if (copy.field.distance[i] < 0 && copy.tissue[i] == Tissue::kPulp)
      ++pulp[std::lround(glm::dot(n, copy.frame.to_world(dvec3(x, y, z)) - middle) / copy.frame.voxel)];
  });
  const auto most = std::ranges::max_element(pulp, {}, [](const auto& layer) { return layer.second; });
  const double offset = most == pulp.end() ? 0 : static_cast<double>(most->first) * copy.frame.voxel;
  return {n, -glm::dot(n, middle) - offset};
}

/// Adds the meshes that the chosen teaching view shows in addition to the tissue's surface, for example the cut face of
/// a section.
void add_view(PictureStage& stage, const RenderOptions& options, const Scene& scene,
              const haptics::TissueVolume& volume) {
  const dvec3 origin = volume.frame().origin;
  glm::dvec4 plane{0, 0, 0, 1};
  render::View view = render::View::kLook;
  if (options.view == "section" || options.view == "temperature") {
    view = options.view == "section" ? render::View::kSection : render::View::kTemperature;
    plane =
        options.plane.empty() ? usual_plane(scene, volume, stage.rig().head.eye_center) : parse_plane(options.plane);
    if (const auto around = view == render::View::kSection ? surroundings_shape(scene.surroundings) : std::nullopt)
      stage.show_inside(render::kSectionFaceAround, around->section_face(dvec3(plane), -plane.w, origin), origin);
  } else if (options.view == "xray") {
    view = render::View::kXray;
  } else if (options.view == "difference") {
    view = render::View::kDifference;
  }
  for (const ViewBody& body : view_bodies(view, plane, 0, volume)) stage.show_inside(body.mesh, body.bricks, origin);
  stage.show_as(view, plane);
}

/// The colour for a density: green for 0 (no resistance), white for 1 (dentin), red from 1.5 on (paper S2 of
/// docs/papers.md, Fig. 9).
glm::vec3 density_color(double density) {
  const glm::vec3 soft(0.25f, 0.65f, 0.3f), middle(0.93f, 0.92f, 0.88f), hard(0.85f, 0.25f, 0.2f);
  const auto below = static_cast<float>(std::clamp(density, 0.0, 1.0));
  const auto above = static_cast<float>(std::clamp(2 * (density - 1), 0.0, 1.0));
  return density < 1 ? glm::mix(soft, middle, below) : glm::mix(middle, hard, above);
}

/// Returns the tissue's spheres, sorted from far to near, because nearer spheres are drawn over farther ones.
std::vector<render::Particle> sphere_particles(const haptics::Carver& carver, const haptics::ServoSettings& settings,
                                               const dvec3& eye) {
  std::vector<haptics::ShownSphere> spheres = haptics::shown_spheres(carver, settings);
  const auto far = [&](const haptics::ShownSphere& s) { return glm::dot(s.p_W - eye, s.p_W - eye); };
  std::sort(spheres.begin(), spheres.end(), [&](const auto& a, const auto& b) { return far(a) > far(b); });
  std::vector<render::Particle> particles;
  particles.reserve(spheres.size());
  if (spheres.empty()) return particles;
  // Farther spheres are darker, which makes the shape easier to see.
  constexpr float kFarthest = 0.45f;
  const double first = std::sqrt(far(spheres.back())), last = std::sqrt(far(spheres.front()));
  for (const haptics::ShownSphere& s : spheres) {
    const double depth = (std::sqrt(far(s)) - first) / std::max(last - first, 1e-9);
    const float light = glm::mix(1.0f, kFarthest, static_cast<float>(std::sqrt(depth)));
    particles.push_back({glm::vec3(s.p_W), static_cast<float>(s.radius), light * density_color(s.density), 1});
  }
  return particles;
}

ordered_json eye_json(const display::EyeView& eye) {
  const display::Frustum& f = eye.frustum;
  const double mm = 1 / kMillimetre;
  return {{"view", display::row_major_mm(eye.view)},
          {"projection", display::row_major_mm_projection(f)},
          {"frustum",
           {{"left", f.left * mm},
            {"right", f.right * mm},
            {"bottom", f.bottom * mm},
            {"top", f.top * mm},
            {"near", f.near * mm},
            {"far", f.far * mm}}},
          {"flip", eye.flip},
          {"position_mm", {eye.position.x * mm, eye.position.y * mm, eye.position.z * mm}}};
}

ordered_json stats_json(const render::FrameStats& s) {
  return {{"drawn", s.drawn},
          {"views", s.views},
          {"bricks",
           {{"drawn", s.bricks_drawn},
            {"culled", s.bricks_culled},
            {"facing_away", s.bricks_facing_away},
            {"covered", s.bricks_covered},
            {"unchanged", s.bricks_unchanged}}},
          {"triangles", s.triangles},
          {"passes", s.passes},
          {"commands", s.commands},
          {"pipelines", s.pipelines},
          {"mirror", {{"passes", s.mirror_passes}, {"bricks", s.mirror_bricks}, {"triangles", s.mirror_triangles}}},
          {"frames", s.frames}};
}

/// Writes the lights and the tissues' colours as JSON, so that another renderer can draw the same scene.
ordered_json light_json(const render::Lights& lights) {
  namespace shared = render::shared;
  return {{"toward_lamp", vec(glm::normalize(lights.key), 1)},
          {"lamp_strength", lights.key_strength},
          {"lamp_color", vec(shared::kLampColor, 1)},
          {"lamp_half_angle", shared::kLampHalfAngle},
          {"up", vec(glm::normalize(lights.up), 1)},
          {"window", vec(render::toward_window(lights), 1)},
          {"room",
           {{"floor", vec(lights.ambient * dvec3(shared::kRoomFloor), 1)},
            {"ceiling", vec(lights.ambient * dvec3(shared::kRoomCeiling), 1)},
            {"window", vec(lights.ambient * dvec3(shared::kRoomWindow), 1)}}}};
}

ordered_json colors_json(const MaterialTable& materials) {
  ordered_json colors = ordered_json::object();
  const auto looks = render::appearances_of(materials);
  for (int t = 1; t < render::kMatterCount; ++t) {
    const dvec3& c = looks[static_cast<std::size_t>(t)].color;
    colors[std::string(render::matter_name(t))] = {c.x, c.y, c.z};
  }
  return colors;
}

/// True if the eye's picture may show a part of the box from lo to hi (m, frame W).
bool may_show(const display::EyeView& eye, const dvec3& lo, const dvec3& hi) {
  constexpr int kCorners = 8, kPlanes = 5;
  int beyond[kPlanes] = {};
  for (int corner = 0; corner < kCorners; ++corner) {
    const dvec3 p(corner & 4 ? hi.x : lo.x, corner & 2 ? hi.y : lo.y, corner & 1 ? hi.z : lo.z);
    const glm::dvec4 c = eye.projection * eye.view * glm::dvec4(p, 1);
    const bool is_beyond[kPlanes] = {c.x<-c.w, c.x> c.w, c.y<-c.w, c.y> c.w, c.z < 0};
    for (int plane = 0; plane < kPlanes; ++plane) beyond[plane] += is_beyond[plane];
  }
  return std::ranges::none_of(beyond, [](int corners) { return corners == kCorners; });
}

/// Warns if the tissue is outside the picture.
bool check_picture(const haptics::TissueVolume& tissue, std::span<const display::EyeView> eyes, const fs::path& rig) {
  glm::ivec3 a, b;
  tissue.bounds(a, b);
  if (a.x > b.x) return false;
  const dvec3 lo = tissue.frame().to_world(dvec3(a)), hi = tissue.frame().to_world(dvec3(b));
  if (std::ranges::any_of(eyes, [&](const display::EyeView& eye) { return may_show(eye, lo, hi); })) return true;
  const dvec3 middle = (lo + hi) / 2.0 / kMillimetre;
  log::warn(
      "the tissue, around ({:.1f}, {:.1f}, {:.1f}) mm, lies outside the picture of {}: move it, or use another rig",
      middle.x, middle.y, middle.z, rig.string());
  return false;
}

void run(const RenderOptions& options) {
  if (options.geometry && options.view != "look")
    throw Error("", "--geometry", "--view " + options.view, "--view look, whose triangles it writes");
  if (!options.plane.empty() && options.view != "section" && options.view != "temperature")
    throw Error("", "--plane", "--view " + options.view, "--view section or temperature, whose plane it is");
  if (!options.ideal.empty() && options.view != "difference")
    throw Error("", "--ideal", "--view " + options.view, "--view difference, whose ideal it is");
  // The recording, if a moment of a session is drawn; empty if a scene is drawn.
  std::optional<SessionPlayer> session;
  if (options.scene.ends_with(".h5")) session.emplace(fs::path(options.scene));
  if (session && !options.volume.empty())
    throw Error("", "--volume", options.volume, "a scene: a recorded session has its own tissue");
  const Scene scene = session ? session->scene() : read_scene(options.scene);
  if (options.finished && (session || !options.volume.empty()))
    throw Error("", "--finished", session ? "a recorded session" : "--volume", "a scene with its own tissue");
  if (options.at != 0 && options.pose.empty() && !session)
    throw Error("", "--at", fmt::format("{}", options.at),
                "--pose HAND.csv, or a recorded session: it is a time in one of them");
  const fs::path rig_path = options.rig.empty() ? usual_rig(scene, "closeup") : find_rig(options.rig);
  display::DisplayRig rig = display::load_rig(rig_path);
  if (rig.kind == display::DisplayKind::kHmd)
    throw Error(rig_path.string(), "\"display\"", "hmd",
                "window, mirror or offscreen: a headset's views are its runtime's");
  const display::Layout layout = rig.screen.layout;
  if (!options.size.empty()) draw_eyes_at(rig, parse_size(options.size));
  ServoTick tick;
  if (!options.pose.empty()) {
    const haptics::HandPath::Row row = haptics::read_hand_path(options.pose, tool_names(scene)).at(options.at);
    tick.X_WT = tick.X_WG = row.X_WT;
    tick.tool = row.tool;
    tick.spindle = scene.servo.spindle.free_speed;
  }
  std::optional<haptics::TissueVolume> volume;  // tissue of the scene, if a scene is drawn
  if (!session) volume = options.volume.empty() ? load_tissue(scene) : haptics::TissueVolume::load(options.volume);
  const haptics::TissueVolume& start = session ? session->tissue() : *volume;
  std::optional<World> still;  // state of the scene, if a scene is drawn
  if (!session) still.emplace(scene).apply(tick);
  World& world = session ? session->world() : *still;
  std::optional<haptics::TissueVolume> ideal;
  if (options.view == "difference") {
    ideal = options.ideal.empty() ? ideal_tissue(scene, start) : haptics::TissueVolume::load(options.ideal);
    if (!ideal)
      throw Error("", "--ideal", "nothing", "--ideal VOLUME.vdb, the tooth as it should become, or a task's ideal");
  }
  if (options.view == "temperature") {
    if (!scene.heat)
      throw Error(options.scene, "--view", options.view, "a scene with the key \"heat\", which computes temperatures");
    if (session) session->add_heat();
    if (still) still->add_heat(start, 1000);
  }
  if (options.finished) volume = finished_tissue(scene, start);
  if (options.magnify > 0) rig.magnify = options.magnify;
  rig = magnified_for(rig, start);
  if (session) session->seek(options.at);
  // A carver, which cuts the tissue, is needed if the picture shows a moment of a session, or the triangles or spheres
  // of a contact model. Otherwise, the picture shows the volume of the file.
  std::optional<haptics::Carver> own;
  const bool spheres_wanted = options.view == "spheres";
  if (!session && (spheres_wanted || (options.volume.empty() && draws_own_surface(scene)))) {
    const haptics::ServoSettings settings = servo_settings(scene, *volume, 1000);
    own.emplace(std::move(*volume), settings);
  }
  haptics::Carver* const carver = session ? &session->carver() : own ? &*own : nullptr;
  std::vector<render::Particle> spheres;
  if (spheres_wanted) {
    spheres = sphere_particles(*carver, servo_settings(scene, carver->volume(), 1000), rig.head.eye_center);
    if (spheres.empty())
      throw Error(options.scene, "model", std::string(model_name(scene)), "packing, whose spheres are shown");
  }
  haptics::TissueVolume& shown = carver ? carver->volume() : *volume;
  PictureStage::Options stage_options;
  for (const render::Quality& step : render::kQualityLadder)
    if (step.name == options.quality) stage_options.quality = step;
  stage_options.hud = options.hud;
  if (options.hud) stage_options.language = hud_language(user_language(options.language));
  stage_options.handpieces = scene.handpieces;
  // A geometry file contains the tool without a handpiece.
  if (options.geometry) stage_options.handpieces.shown = false;
  // A geometry file contains neither chips nor the suction tip.
  const Look look{.tool = !options.pose.empty() || session, .debris = !options.geometry && !spheres_wanted};
  stage_options.validation = options.validate;
  PictureStage stage(rig, scene.servo, stage_options);
  Surroundings around = world.surroundings();
  // If the tooth is uncut, the gum hides its root, so the root need not be drawn. Otherwise, the eye may see the root
  // through a cavity.
  if (session || options.finished || !options.volume.empty()) around.covered = glm::dvec4(0);
  stage.surround(around);
  stage.show_spheres(spheres);
  ShownGeometry geometry(scene.servo.materials);
  TissueView view(surface_tolerance(rig, shown.frame().voxel, stage_options.quality), scene.drawn_as);
  if (spheres.empty()) {
    std::vector<render::MeshUpdate> surface = carver ? view.update(*carver) : view.update(shown);
    if (ideal) mark_difference(ToothField(*ideal, kDifferenceReach), shown.frame().origin, surface);
    stage.show(surface, shown.frame().origin);
    if (options.geometry) geometry.add(render::kWorkingTooth, surface, shown.frame().origin);
    add_view(stage, options, scene, shown);
  }
  const render::FrameStats drawn = stage.draw(world, look);
  const render::FrameStats again = stage.draw(world, look);

  const auto eyes = display::eye_views(rig);
  const bool shows_tissue = check_picture(shown, eyes, rig_path);
  const glm::ivec2 eye_size = display::eye_pixels(layout, rig.screen.pixels);
  ordered_json frame{{"scene", scene.name},
                     {"rig", rig_path.string()},
                     {"view", options.view},
                     {"layout", display::name_of(layout)},
                     {"size", {eye_size.x, eye_size.y}},
                     {"left", eye_json(eyes[0])},
                     {"right", eye_json(eyes[1])},
                     {"shows_tissue", shows_tissue},
                     {"frame", stats_json(drawn)},
                     // Statistics of a second, equal frame. Since nothing has moved, no drawing command is recorded for
                     // it.
                     {"unchanged", stats_json(again)}};
  ordered_json skipped = ordered_json::object();
  if (!look.tool) skipped["tool"] = "no --pose";
  if (!options.hud) skipped["hud"] = "no --hud";
  const std::size_t particles = spheres_wanted                  ? spheres.size()
                                : look.debris && world.debris() ? world.debris()->alive()
                                                                : 0;
  if (particles == 0) skipped["particles"] = "none alive";
  if (!spheres.empty()) frame["spheres"] = spheres.size();
  if (scene.mouth_mirror.diameter == 0)
    skipped["mirror"] = "the scene has no mouth mirror";
  else if (drawn.mirror_passes == 0)
    skipped["mirror"] = "no eye sees the glass";
  if (rig.mirror) skipped["background"] = "black: the hand shows through the mirror";
  if (drawn.views == 1) skipped["right"] = "mono: both eyes see the one view";
  frame["skipped"] = skipped;
  const render::Quality& step = stage_options.quality;
  frame["quality"] = {{"step", step.name},
                      {"samples", step.samples},
                      {"scale", step.scale},
                      {"light", step.light_per_vertex ? "per corner" : "per pixel"}};
  const double record_time = stage.timing().record;
  frame["device"] = stage.device_name();
  if (options.validate) frame["validation_messages"] = stage.validation_messages();

  frame["light"] = light_json(stage.lights());
  frame["colors"] = colors_json(scene.servo.materials);

  const fs::path out = options.out;
  make_folder(out);
  std::vector<std::string> written;
  const auto write = [&](const char* name, const render::Picture& eye) {
    render::Picture picture = render::scaled_to(eye, eye_size);
    stage.write_over(picture);
    render::write_png(out / name, picture);
    written.push_back((out / name).string());
  };
  if (options.eye != "right") write("left.png", stage.eye(0));
  if (options.eye != "left") write("right.png", stage.eye(1));
  if (options.eye == "both") {
    render::write_png(out / "screen.png", stage.screen());
    written.push_back((out / "screen.png").string());
  }
  if (options.geometry) {
    for (const SurroundingMesh& mesh : around.meshes) geometry.add(mesh.id, mesh.bricks, mesh.origin);
    if (look.tool)
      geometry.add(drawn_tool(world.tool(), scene.servo.spindle, stage_options.handpieces).tool, world.tick().X_WG,
                   world.tick().spindle > 0 ? 1.0f : 0.0f);
    geometry.write(out / "geometry.ply");
    written.push_back((out / "geometry.ply").string());
  }
  // Measures the drawing times as in a running session, without the first frame, which includes the set-up. Eyes and
  // screen move by 1 µm per frame, because unchanged frames are redrawn only in part. A recording goes on playing.
  constexpr double kFramePeriod = 1.0 / 90, kMeasured = 0.25;  // s: session time per frame; limit of Σ drawing times
  constexpr std::size_t kMaxFrames = 45;
  std::vector<double> times, gpu_times;
  std::array<std::vector<double>, render::kFrameParts.size()> parts;
  for (double sum = 0, at = options.at; times.size() < kMaxFrames && sum < kMeasured; sum += times.back()) {
    for (dvec3* p : {&rig.screen.lower_left, &rig.screen.lower_right, &rig.screen.upper_left, &rig.head.eye_center})
      *p += 1e-6 * rig.head.right;
    stage.look_from(rig);
    std::vector<render::MeshUpdate> changed;
    if (session) {
      session->seek(at += kFramePeriod);
      changed = view.update(*carver);
    }
    const Nanos began = now();
    if (!changed.empty()) stage.show(changed, shown.frame().origin);
    stage.draw(world, look);
    times.push_back(to_seconds(now() - began));
    gpu_times.push_back(stage.gpu_times().frame);
    for (std::size_t i = 0; i < parts.size(); ++i) parts[i].push_back(stage.gpu_times().parts[i]);
  }
  const double took = quantile(times, 0.5);
  frame["timing"] = {{"record_ms", record_time * 1e3}, {"gpu_ms", quantile(gpu_times, 0.5)},
                     {"frame_ms", took * 1e3},         {"worst_ms", quantile(times, 1) * 1e3},
                     {"frames", times.size()},         {"frames_per_second", 1 / took}};
  for (std::size_t i = 0; i < parts.size(); ++i)
    frame["timing"]["gpu_parts_ms"][render::kFrameParts[i]] = quantile(parts[i], 0.5);
  write_file_atomically(out / "frame.json", frame.dump(2) + "\n", FileKind::kJson);
  written.push_back((out / "frame.json").string());

  if (options.json) {
    frame["written"] = written;
    fmt::print("{}\n", frame.dump(2));
    return;
  }
  fmt::print("{} triangles in {} bricks drawn ({} culled, {} facing away), {} view{}, {}x{} each\n", drawn.triangles,
             drawn.bricks_drawn, drawn.bricks_culled, drawn.bricks_facing_away, drawn.views,
             drawn.views == 1 ? "" : "s", eye_size.x, eye_size.y);
  for (const std::string& file : written) fmt::print("wrote {}\n", file);
}

}  // namespace

void add_render_command(cli::Command& app) {
  auto options = std::make_shared<RenderOptions>();
  cli::Command* command = app.add_command("render", "Pictures of a scene for both eyes, and their matrices");
  command->footer(
      "Example:\n  typodont render assets/scenes/molar-caries.json --rig closeup --out pictures --size 1280x1024");
  command
      ->add_option("scene", options->scene,
                   "scene file (JSON), the name of one in assets/scenes, or a recorded session (.h5)")
      ->required();
  command->add_option("--rig", options->rig,
                      "rig file (JSON), or the name of one in assets/rigs; without it the scene's rig, or closeup");
  command->add_option("--magnify", options->magnify, "magnify the scene by this factor", cli::range(0.1, 100.0));
  command
      ->add_option("--out", options->out, "folder for left.png, right.png, screen.png and frame.json",
                   cli::writes_folder())
      ->required();
  command->add_option("--size", options->size, "WIDTHxHEIGHT of one eye's picture; the rig's pixels when not given");
  command->add_setting("--eye", options->eye, "which eye to write; screen.png comes with both",
                       cli::one_of({"left", "right", "both"}));
  command->add_option("--pose", options->pose, "HAND.csv: draw the tool where the hand holds it");
  command->add_setting("--at", options->at, "time in HAND.csv or in the session, s");
  command->add_setting(
      "--view", options->view,
      "natural, or a view for teaching: section, X-ray, difference from an ideal, temperature, the spheres of the "
      "model packing",
      cli::one_of({"look", "section", "xray", "difference", "temperature", "spheres"}));
  command->add_option(
      "--plane", options->plane,
      "section, temperature: NX,NY,NZ,OFFSET_MM; the side with N·p > OFFSET is kept; default: along the tooth's axis "
      "through its pulp, or through the centre");
  command->add_option("--ideal", options->ideal,
                      "difference: the tooth as it should become (.vdb); else the scene's task says");
  command->add_option("--volume", options->volume, "draw this volume (.vdb) instead of the scene's tissue");
  command->add_flag("--finished", options->finished,
                    "draw the tooth as the scene's task wants it in the end; of an implant exercise the bed");
  std::vector<std::string> steps;
  for (const render::Quality& step : render::kQualityLadder) steps.emplace_back(step.name);
  command->add_setting("--quality", options->quality, "step of the quality ladder", cli::one_of(steps));
  command->add_flag("--geometry", options->geometry,
                    "also write geometry.ply: the triangles of the picture, for another renderer");
  command->add_flag("--hud", options->hud, "also draw text");
  command->add_option("--language", options->language,
                      "language of this text: en, de or zh; otherwise the window's language");
  command->add_flag("--validate", options->validate, "run under the Vulkan validation layer and count its messages");
  command->add_flag("--json", options->json, "print frame.json on standard output too");
  command->callback([options, command] {
    command->refuse_without({"--language"}, options->hud, "--hud");
    run(*options);
  });
}

}  // namespace typodont
