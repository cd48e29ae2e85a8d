// Tests the caches that are kept between runs (engine/base/cache.h, engine/gpu/driver_cache.h,
// engine/app/tissue/sampled_tissue.h, engine/app/surroundings, engine/render/light_scene.h,
// engine/render/tissue_light.h). They change only the time that a start takes. A cache entry is computed again if it is
// damaged, if it is of another version, or if there is no folder for it.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <functional>
#include <map>

#include "engine/app/tissue/sampled_tissue.h"
#include "haptics/import/mesh_solid.h"
#include "tests/support/program.h"

namespace typodont::test {
namespace {

namespace fs = std::filesystem;

using Files = std::map<std::string, std::string>;  // name → content

Files files_in(const fs::path& folder) {
  Files files;
  if (fs::is_directory(folder))
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      if (entry.is_regular_file()) files[entry.path().lexically_relative(folder).string()] = read_text(entry.path());
  return files;
}

void put(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
}

std::string noise(std::size_t size) {
  std::string text(size, 0);
  std::uint32_t state = 12345;
  for (char& c : text) c = static_cast<char>((state = state * 1664525u + 1013904223u) >> 24);
  return text;
}

struct Damage {
  const char* name;
  std::function<std::string(const std::string&)> of;
};
const std::array kDamages{
    Damage{"cut short", [](const std::string& was) { return was.substr(0, was.size() / 2); }},
    Damage{"empty", [](const std::string&) { return std::string(); }},
    Damage{"noise", [](const std::string& was) { return noise(was.size()); }},
    Damage{"one bit", [](std::string was) { return was.empty() ? was : (was[was.size() / 2] ^= 4, was); }},
    Damage{"another version", [](const std::string& was) { return "typodont 99\n" + was; }}};

constexpr const char* kWedge =
    "v 0 0 0\nv 8 0 0\nv 8 8 0\nv 0 8 0\nv 4 4 6\nf 1 4 3\nf 1 3 2\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";

struct Kept : testing::Test {
  ProgramFolder program{TYPODONT_PROGRAM};
  const std::string cache = program / "cache";

  Ran run(const std::string& arguments, const std::string& where) {
    return program.run(arguments, fmt::format("env -u MESA_SHADER_CACHE_DIR TYPODONT_CACHE={}", where));
  }
};

TEST_F(Kept, ADamagedShaderCacheIsReplacedAndThePictureIsUnchanged) {
  const std::string scene = program.write("scene.json", R"({"name": "ball", "tissue": {"voxel_mm": 0.3, "solids": [
    {"tissue": "enamel", "solid": {"sphere": {"center_mm": [0, 0, 0], "radius_mm": 5}}}]}, "tool": "round_012",
    "spindle_krpm": 300, "parts": ["haptics", "render"]})");
  const auto picture = [&](const std::string& where) {
    expect_ok(run(fmt::format("render {} --out {} --size 96x72 --eye left", scene, program / "pictures"), where));
    return read_text(program / "pictures/left.png");
  };
  const std::string first = picture(cache);
  const Files kept = files_in(cache);
  ASSERT_FALSE(first.empty());
  ASSERT_GT(kept.size(), 1u) << "the driver keeps nothing";
  EXPECT_EQ(picture(cache), first);
  EXPECT_EQ(files_in(cache), kept) << "a warm start makes nothing anew";
  for (const Damage& damage : kDamages) {
    for (const auto& [name, content] : kept) put(fs::path(cache) / name, damage.of(content));
    EXPECT_EQ(picture(cache), first) << damage.name;
    const Files now = files_in(cache);
    for (const auto& [name, content] : kept) {
      const auto found = now.find(name);
      EXPECT_TRUE(found == now.end() || content.empty() || found->second != damage.of(content))
          << damage.name << ": " << name;
    }
    EXPECT_GE(now.size(), kept.size()) << damage.name;
    EXPECT_EQ(picture(cache), first) << damage.name;
    EXPECT_EQ(files_in(cache), now) << damage.name << ": warm again";
    // Damages one entry only; the list of the entries stays complete.
    for (const auto& [name, content] : now) {
      if (content.size() < 1000) continue;
      put(fs::path(cache) / name, damage.of(content));
      EXPECT_EQ(picture(cache), first) << damage.name << ": " << name;
      EXPECT_NE(read_text(fs::path(cache) / name), damage.of(content)) << damage.name << ": " << name;
      break;
    }
  }
  put(program / "file", "not a folder");
  EXPECT_EQ(picture(program / "file"), first);
  EXPECT_EQ(picture("/proc/self"), first) << "nothing can be written there";
}

TEST_F(Kept, ADamagedMeshCacheIsReplacedAndTheTicksAreUnchanged) {
  program.write("wedge.obj", kWedge);
  const std::string scene = program.write("scene.json", R"({"name": "wedge", "tissue": {"voxel_mm": 0.2, "solids": [
    {"tissue": "dentin", "solid": {"mesh": {"file": "wedge.obj"}}}]}, "tool": "round_012", "spindle_krpm": 300, "parts": ["haptics"]})");
  const std::string hand =
      program.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,4,4,8,1,0,0,0,1\n0.5,4.5,4,5,1,0,0,0,1\n");
  const auto ticks = [&](const std::string& where) {
    expect_ok(run(fmt::format("servo {} --hand {} --out {} --no-timing", scene, hand, program / "ticks.csv"), where));
    return read_text(program / "ticks.csv");
  };
  const std::string none = ticks(program / "hand.csv");  // without a folder nothing is kept
  ASSERT_FALSE(none.empty());
  EXPECT_EQ(ticks(cache), none);
  const Files kept = files_in(cache);
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(ticks(cache), none);
  for (const Damage& damage : kDamages) {
    put(fs::path(cache) / kept.begin()->first, damage.of(kept.begin()->second));
    EXPECT_EQ(ticks(cache), none) << damage.name;
    EXPECT_EQ(files_in(cache), kept) << damage.name << ": replaced";
  }
  // Another mesh with the same name has another key.
  std::string lower = read_text(program / "wedge.obj");
  program.write("wedge.obj", lower.replace(lower.find("4 4 6"), 5, "4 4 5"));
  EXPECT_NE(ticks(cache), none);
  EXPECT_EQ(files_in(cache).size(), 2u);
}

TEST_F(Kept, AMeshThatOneProgramSampledIsUsedByAnotherProgramOfTheSameSources) {
  program.write("wedge.obj", kWedge);
  const std::string tissue = R"({"voxel_mm":0.2,"solids":[{"tissue":"dentin","solid":{"mesh":{"file":"wedge.obj"}}}]})";
  // This test program samples the mesh first.
  ::setenv("TYPODONT_CACHE", cache.c_str(), 1);
  sampled_tissue(Json::parse(tissue, "tissue"), {.find = [&](const Json& name) { return program / name.string(); },
                                                 .read_mesh = haptics::read_mesh_solid});
  ::unsetenv("TYPODONT_CACHE");
  const Files kept = files_in(cache);
  ASSERT_EQ(kept.size(), 1u);
  const std::string scene =
      program.write("scene.json", R"({"name": "wedge", "tissue": )" + tissue + R"(, "tool": "round_012"})");
  const std::string hand =
      program.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,4,4,8,1,0,0,0,1\n0.1,4,4,7.9,1,0,0,0,1\n");
  expect_ok(run(fmt::format("servo {} --hand {} --out {}", scene, hand, program / "ticks.csv"), cache));
  EXPECT_EQ(files_in(cache), kept);
}

TEST_F(Kept, ADamagedCacheOfTheMouthIsReplacedAndThePictureIsUnchanged) {
  // The shaders come from the cache of all tests, because this test does not examine them.
  ASSERT_NE(std::getenv("XDG_CACHE_HOME"), nullptr);
  const std::string shaders =
      fmt::format("env MESA_SHADER_CACHE_DIR={} TYPODONT_CACHE=", std::getenv("XDG_CACHE_HOME"));
  const auto picture = [&](const std::string& where) {
    expect_ok(program.run("render root-canal-access --rig closeup --eye left --quality fast --size 160x128 --out " +
                              (program / "pictures"),
                          shaders + where));
    return read_text(program / "pictures/left.png");
  };
  const auto kept = [&] {
    Files all = files_in(fs::path(cache) / "surroundings");
    for (const char* part : {"light", "tissue_light"}) all.merge(files_in(fs::path(cache) / part));
    return all;
  };
  const std::string fresh = picture(cache);
  ASSERT_FALSE(fresh.empty());
  const Files first = kept();
  ASSERT_EQ(first.size(), 3u);
  EXPECT_EQ(picture(cache), fresh);
  EXPECT_EQ(kept(), first) << "a warm start makes nothing anew";
  Files damaged;
  for (const char* part : {"surroundings", "light", "tissue_light"})
    for (const auto& [name, content] : files_in(fs::path(cache) / part))
      put(fs::path(cache) / part / name, damaged[part] = kDamages[3].of(content));
  EXPECT_EQ(picture(cache), fresh);
  const Files again = kept();
  EXPECT_EQ(again.size(), 3u);
  for (const auto& [name, content] : again)
    for (const auto& [part, bad] : damaged) EXPECT_NE(content, bad) << part;
}

}  // namespace
}  // namespace typodont::test
