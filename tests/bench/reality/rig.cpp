#include "tests/bench/reality/rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "engine/app/assets.h"
#include "engine/app/scene.h"
#include "engine/app/task/heat.h"
#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/lockstep.h"
#include "tests/support/haptic_bench.h"

namespace typodont::bench {

namespace {

using namespace literals;

// Stiffness of the rig, N/m: deflects by 10 µm at 1 N, by 0.2 mm at 200 N.
constexpr double kToothRig = 1e5, kBoneRig = 1e6;
constexpr double kStroke = 10.0_mm, kToothStroke = 6.0_mm, kSlotLength = 8.0_mm, kSlabDepth = 6.0_mm;
constexpr double kGap = 0.02_mm;   // from the loaded hand to the first contact
constexpr double kSettling = 0.2;  // of a run, not measured
constexpr double kToothVoxel = 0.1_mm;
constexpr const char* kLab = "composite";  // holds the material of the laboratory

double value(const Conditions& c, std::string_view key) {
  const auto found = c.find(key);
  if (found == c.end()) throw Error("experiments.csv", key, "nothing", "a number");
  return std::stod(found->second);
}
double value_or(const Conditions& c, std::string_view key, double fallback) {
  return c.contains(key) ? value(c, key) : fallback;
}

haptics::Spindle motor_of(const Conditions& c) {
  haptics::Spindle motor;
  if (c.contains("motor")) motor = load_spindle(c.at("motor"));
  if (c.contains("krpm")) motor.free_speed = value(c, "krpm") * kKrpm;
  if (c.contains("free_krpm")) motor.free_speed = value(c, "free_krpm") * kKrpm;
  motor.run_up_time = 0;
  return motor;
}

haptics::Tool tool_of(const Conditions& c) {
  haptics::Tool tool = load_tool(c.at("tool"));
  if (c.contains("diameter_mm")) tool.diameter = value(c, "diameter_mm") * kMillimetre;
  if (c.contains("length_mm")) tool.length = value(c, "length_mm") * kMillimetre;
  if (c.contains("grit_um")) tool.grit = value(c, "grit_um") * kMicrometre;
  tool.shank_length = tool.safe_length = 0;
  return tool;
}

/// All tissues as stiff as the rig, so that it deflects by force / stiffness.
MaterialTable materials_of(const Conditions& c) {
  MaterialTable table = load_materials();
  const std::string& name = c.at("tissue");
  if (name != "tooth" && !tissue_named(name)) {
    Material& material = table[static_cast<std::size_t>(*tissue_named(kLab))] = {};
    read_material(Json::load(TYPODONT_REALITY "/materials.json")[name], material);
  }
  for (Material& material : table) material.stiffness = 1000;
  return table;
}

/// A molar of 10 × 10 × 10 mm below z = 0, with an enamel of 1 mm.
haptics::TissueVolume tooth(const Conditions& c, double voxel) {
  const double pulp = -1 - value(c, "dentin_mm") - 1.5;
  return haptics::TissueVolume(haptics::read_solids(Json::parse(
      fmt::format(
          R"({{"voxel_mm":{:g},"solids":[{{"tissue":"dentin","solid":{{"box":{{"size_mm":[10,10,10],"center_mm":[0,0,-5]}}}}}},
          {{"tissue":"enamel","solid":{{"box":{{"size_mm":[10,10,1],"center_mm":[0,0,-0.5]}}}}}},
          {{"tissue":"pulp","solid":{{"box":{{"size_mm":[4,4,3],"center_mm":[0,0,{:g}]}}}}}}]}})",
          voxel / kMillimetre, pulp),
      "tooth")));
}

/// Its face is z = 0, its front x = 0.
test::HapticBench slab(const Conditions& c, const haptics::ServoSettings& settings, const dvec3& size_mm,
                       const dvec3& center_mm) {
  const std::string& name = c.at("tissue");
  if (name == "tooth") return {tooth(c, kToothVoxel), settings, materials_of(c)};
  const std::string json = fmt::format(
      R"({{"voxel_mm":{:g},"solids":[{{"tissue":"{}","solid":{{"box":{{"size_mm":[{:g},{:g},{:g}],"center_mm":[{:g},{:g},{:g}]}}}}}}]}})",
      settings.tool.radius() / kMillimetre / 10, tissue_named(name) ? name : kLab, size_mm.x, size_mm.y, size_mm.z,
      center_mm.x, center_mm.y, center_mm.z);
  return {haptics::TissueVolume(haptics::read_solids(Json::parse(json, "slab"))), settings, materials_of(c)};
}

/// Sums from the first to the last measured tick.
struct Sums {
  Nanos begin = 0, end = 0;
  double from = 0, to = 0;  // m, along the push
  double removed_from = 0, removed = 0;
  double energy = 0, angle = 0, force = 0, across = 0, along = 0;
  long ticks = 0;
};

}  // namespace

Measured run_rig(const std::string& rig, const Conditions& c, double seconds) {
  haptics::ServoSettings settings;
  settings.tool = tool_of(c);
  settings.spindle = motor_of(c);
  settings.method = haptics::default_contact_method();
  settings.damping = 0;
  settings.friction = settings.passivity = false;
  settings.force_limit = 1e6;
  const bool plunges = rig == "plunge", slides = rig == "face" || rig == "tooth";
  settings.stiffness = plunges ? kBoneRig : value_or(c, "rig_N_per_mm", kToothRig / 1e3) * 1e3;
  const double r = settings.tool.radius(), head_mm = settings.tool.length / kMillimetre;

  // The tool lies along y, except in "plunge".
  const dquat R = plunges ? dquat(1, 0, 0, 0) : glm::angleAxis(-kPi / 2, dvec3(1, 0, 0));
  const dvec3 push = plunges || slides ? dvec3(0, 0, -1) : dvec3(1, 0, 0);
  const double wide = plunges ? 8 : value_or(c, "engaged_mm", head_mm + 1), deep = kSlabDepth / kMillimetre;
  const double cut = value_or(c, "cut_mm", 0), cuts = value_or(c, "cuts", 0);
  const double along = plunges ? 8 : slides ? kStroke / kMillimetre + 4 : kSlotLength / kMillimetre + cut * cuts;
  test::HapticBench bench = slab(c, settings, {along, wide, deep}, {plunges || slides ? 0 : along / 2, 0, -deep / 2});

  const double depth = rig == "mill" ? value(c, "depth_um") * kMicrometre : r;
  const bool loaded = c.contains("load_N");
  const double deflection = loaded ? value(c, "load_N") / settings.stiffness : 0;
  const double gap = kGap + deflection;
  const double feed = loaded ? 0 : value(c, "feed_mm_s") * kMillimetre;
  const double stroke = slides ? value(c, "stroke_mm_s") * kMillimetre : 0;
  dvec3 start(0);
  if (plunges) start.z = settings.tool.half() + gap;
  if (slides) start.z = r + gap;
  if (!plunges && !slides) start = {-std::sqrt(r * r - (r - depth) * (r - depth)) - gap, 0, r - depth};

  // Steady: the drill's full diameter, the slot's middle, the strokes after the first.
  const double first = plunges ? r + 0.5_mm : slides ? -gap : r + 0.5_mm;
  const double last = plunges ? kSlabDepth - 0.8_mm : slides ? kSlabDepth : first + 3.0_mm + cut * cuts * kMillimetre;
  std::optional<HeatMeter> heat;
  if (rig == "tooth") {
    const bool cooled = c.contains("coolant_C");
    heat.emplace(session::read_heat_constants(Json::load(assets_folder() / "materials" / "heat.json")),
                 session::HeatSettings{cooled ? value(c, "coolant_C") : HeatMeter::kBody},
                 cooled ? settings.spindle.nozzles->flow : 0, tooth(c, kToothVoxel), std::span(&settings.tool, 1));
  }
  const double way_back = rig == "tooth" ? kToothStroke : kStroke;
  Sums sums;
  std::vector<double> ends{0};  // s, of the cuts, one after the other
  dvec3 at = start;
  for (double t = 0; t < seconds; t += settings.tick) {
    dvec3 hand = loaded ? at + deflection * push : start + feed * t * push;
    if (slides) {
      const double phase = std::fmod(stroke * t / way_back, 2.0);
      hand.x = way_back * (phase < 1 ? phase - 0.5 : 1.5 - phase);
      hand.y = 0;
    } else if (plunges) {
      hand.x = hand.y = 0;
    } else {
      hand.y = 0, hand.z = start.z;
    }
    const ServoTick& tick = bench.tick({hand, R}, 1);
    at = tick.X_WG.p;
    if (heat) heat->add({&tick, 1}, c.contains("coolant_C"));
    const double way = glm::dot(at - start, push) - gap;
    if (way > last) break;
    if (cut > 0 && way > cut * kMillimetre * static_cast<double>(ends.size())) ends.push_back(t);
    const bool measured = way >= first && (plunges || !slides || t > kSettling * seconds);
    if (!measured) continue;
    if (sums.ticks++ == 0) {
      sums.begin = tick.t, sums.from = way, sums.removed_from = total(tick.removed);
      sums.energy = sums.angle = sums.force = sums.across = sums.along = 0;
    }
    sums.end = tick.t, sums.to = way, sums.removed = total(tick.removed);
    sums.energy += tick.cutting_power * settings.tick;
    sums.angle += tick.spindle * settings.tick;
    sums.force += tick.depth * settings.stiffness;
    const double across = glm::dot(tick.f_model_W, tick.n_C_W);
    sums.across += across, sums.along += glm::length(tick.f_model_W - across * tick.n_C_W);
  }

  Measured result;
  if (cut > 0 && static_cast<double>(ends.size()) > cuts) {
    const auto time = [&](double number) {
      const auto i = static_cast<std::size_t>(number);
      return ends[i] - ends[i - 1];
    };
    result.fall = 1 - time(value(c, "from_cut")) / time(cuts);
  }
  if (heat) result.pulp = heat->pulp();
  result.radius = r;
  result.free_speed = settings.spindle.free_speed;
  const double time = to_seconds(sums.end - sums.begin), removed = sums.removed - sums.removed_from;
  if (sums.ticks < 10 || !(time > 0)) return result;
  const double n = static_cast<double>(sums.ticks);
  result.rate = removed / time;
  result.feed = (sums.to - sums.from) / time;
  result.force = sums.force / n;
  result.force_ratio = sums.across > 0 ? sums.along / sums.across : 0;
  result.speed = sums.angle / (n * settings.tick);
  result.torque = sums.angle > 0 ? sums.energy / sums.angle : 0;
  result.energy = removed > 0 ? sums.energy / removed : 0;
  return result;
}

double insert(const Conditions& c, double seconds) {
  // HU cm³/g, grey of foam; HU at hardness 1; mm
  constexpr double kGreyPerDensity = 1050 / 0.64, kCancellousGrey = 1250, kBed = 11.5;
  haptics::ServoSettings settings;
  settings.tool = haptics::read_tool(Json::load(assets_folder() / "implants/bone_level/implant_41_10.json"));
  settings.spindle = load_spindle("implant");
  settings.materials = load_materials();
  settings.stiffness = 3000, settings.damping = 0, settings.torque_limit = 2;
  settings.passivity = false;
  const double bed = value(c, "bed_mm");
  settings.method = haptics::read_contact_method(Json::parse(
      fmt::format(R"({{"implant":{{"beds":[{{"entry_mm":[0,0,0],"axis":[0,0,-1],"depth_mm":{},"diameter_mm":{}}}]}}}})",
                  kBed, bed),
      "model"));
  test::HapticBench bench(
      haptics::TissueVolume(haptics::read_solids(Json::parse(
          fmt::format(
              R"({{"voxel_mm":0.15,"solids":[{{"tissue":"cancellous_bone","hardness":{},"solid":{{"difference":[
                {{"box":{{"size_mm":[9,9,13],"center_mm":[0,0,-6.5]}}}},{{"cylinder":{{"radius_mm":{},"height_mm":{}}}}}]}}}}]}})",
              kGreyPerDensity * value(c, "density") / kCancellousGrey, bed / 2, 2 * kBed),
          "bone"))),
      settings, settings.materials);
  const double half = settings.tool.half();
  double z = half + 3.0_mm, torque = 0;
  for (double t = 0; t < seconds && bench.cut.fill_radius == 0; t += settings.tick) {
    torque = std::max(torque, glm::length(bench.tick({{0, 0, z}}, 1).tau_T_W));
    z = t < 0.5 ? z - 6.0_mm * settings.tick : bench.last.X_WG.p.z - 1.5 / settings.stiffness;
  }
  return torque;
}

MotorCurve brake(const Conditions& c) {
  const haptics::Spindle motor = motor_of(c);
  MotorCurve curve{motor.free_speed, 0, 0, 0};
  constexpr int kSteps = 2000;
  for (int i = 0; i <= kSteps; ++i) {
    const double torque = 1.2 * motor.stall_torque * i / kSteps;
    const double fraction = std::max(0.0, 1 - motor.lost_fraction(torque, 1)),
                 power = torque * motor.free_speed * fraction;
    if (fraction > 0) curve.stall_torque = torque;
    if (power > curve.max_power) curve.max_power = power, curve.power_at = fraction;
  }
  return curve;
}

}  // namespace typodont::bench
