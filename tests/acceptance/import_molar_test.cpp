// Tests `typodont import` through the command line with the CT of a molar that is shipped with the program.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <string>

#include "engine/base/json.h"
#include "engine/base/units.h"
#include "haptics/import/import.h"
#include "haptics/tissue_volume.h"
#include "tests/support/dicom_files.h"
#include "tests/support/import_phantom.h"
#include "tests/support/program.h"

namespace typodont::haptics {
namespace {

using test::Ran;
using test::scratch;
using testing::HasSubstr;

Ran program(const std::string& arguments) {
  return test::ProgramFolder(TYPODONT_PROGRAM).run(arguments);
}

Ran run(const std::string& arguments) {
  return program("import " + arguments);
}

TEST(ImportCommand, TheImportedMolarHasTheRightAnatomy) {
  const auto out = scratch("molar.vdb");
  const Ran ran = expect_ok(run(fmt::format("assets/teeth/molar.nhdr --preset tooth --out {} --preview {} --json",
                                            out.string(), scratch("slices").string())));
  const Json report = Json::parse(ran.out, "report");
  EXPECT_NEAR(report["height_mm"].number(), 21, 1);
  EXPECT_LT(report["crown_false_dentin_share"].number(), 0.02);
  EXPECT_EQ(report["components_kept"].integer(), 1);
  EXPECT_EQ(report["pulp_parts"].integer(), 1);
  EXPECT_GE(report["preview"].items().size(), 10U);
  for (const Json& picture : report["preview"].items()) EXPECT_TRUE(std::filesystem::exists(picture.string()));

  const TissueVolume volume = TissueVolume::load(out);
  const PerTissue mm3 = volume.volumes();
  EXPECT_NEAR(mm3[static_cast<std::size_t>(Tissue::kEnamel)] / kCubicMillimetre,
              report["volume_mm3"]["enamel"].number(), 5);
  // In molars, enamel is about a quarter to a third of the volume, and pulp a few per cent.
  EXPECT_NEAR(report["volume_mm3"]["enamel"].number() / report["volume_mm3"]["total"].number(), 0.27, 0.05);
  EXPECT_NEAR(report["volume_mm3"]["pulp"].number() / report["volume_mm3"]["total"].number(), 0.04, 0.02);

  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  const glm::ivec3 size = hi - lo + 1;
  const std::size_t count = static_cast<std::size_t>(size.x) * size.y * static_cast<std::size_t>(size.z);
  std::vector<float> distance(count);
  std::vector<Tissue> tissue(count);
  volume.copy(lo, size, distance.data(), tissue.data());
  std::size_t i = 0, skin = 0, skin_dentin = 0, low_enamel = 0, shallow_pulp = 0;
  double lowest_pulp = 1e9, highest_pulp = 0;
  for (int x = 0; x < size.x; ++x) {
    for (int y = 0; y < size.y; ++y) {
      for (int z = 0; z < size.z; ++z, ++i) {
        if (distance[i] > 0) continue;
        const double height = volume.frame().to_world(dvec3(lo + glm::ivec3(x, y, z))).z / kMillimetre;
        if (tissue[i] == Tissue::kEnamel) low_enamel += height < 12;
        if (tissue[i] == Tissue::kPulp) {
          lowest_pulp = std::min(lowest_pulp, height);
          highest_pulp = std::max(highest_pulp, height);
          shallow_pulp += distance[i] > -2;
        }
        if (height < 15.5 || distance[i] < -1) continue;  // the crown, wholly above its neck
        ++skin;
        skin_dentin += tissue[i] == Tissue::kDentin;
      }
    }
  }
  EXPECT_EQ(low_enamel, 0U) << "enamel only on the crown";
  EXPECT_LT(static_cast<double>(skin_dentin), 0.02 * static_cast<double>(skin));
  EXPECT_LT(lowest_pulp, 5) << "canals reach down the roots";
  EXPECT_GT(highest_pulp, 13) << "horns of the chamber reach up to the crown";
  EXPECT_LT(shallow_pulp, 20U) << "pulp lies inside the dentin";
}

TEST(ImportCommand, StoresTheHardnessFromGreyValuesInTheVolume) {
  const auto out = scratch("graded.vdb");
  const Ran ran = expect_ok(run(
      fmt::format("assets/teeth/molar.nhdr --hardness-greys 400,830 --voxel-mm 0.3 --out {} --json", out.string())));
  const Json mean = Json::parse(ran.out, "report")["mean_hardness"];
  const TissueVolume volume = TissueVolume::load(out);
  EXPECT_TRUE(volume.graded());
  const auto dentin = static_cast<std::size_t>(Tissue::kDentin);
  const double of_volume = volume.hardness_volumes()[dentin] / volume.volumes()[dentin];
  EXPECT_NEAR(mean["dentin"].number(), of_volume, 0.005);
  EXPECT_GT(of_volume, 0.8);
  EXPECT_LT(of_volume, 1);
  EXPECT_EQ(mean["enamel"].number(), 1);
}

TEST(ImportCommand, ColoursEveryVoxelByItsGreyValue) {
  const auto out = scratch("coloured.vdb");
  expect_ok(run("assets/teeth/molar.nhdr --color-greys 500,1300 --voxel-mm 0.3 --out " + out.string()));
  const TissueVolume volume = TissueVolume::load(out);
  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  const glm::ivec3 size = hi - lo + 1;
  const auto count = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y * size.z);
  std::vector<float> distance(count);
  std::vector<Tissue> tissue(count);
  std::vector<VoxelColor> color(count);
  volume.copy(lo, size, distance.data(), tissue.data());
  volume.copy_colors(lo, size, color.data());
  std::array<double, kTissueCount> green{}, voxels{};
  for (std::size_t i = 0; i < count; ++i) {
    if (distance[i] > -1) continue;
    ASSERT_NE(color[i], kTissueColor);
    green[static_cast<std::size_t>(tissue[i])] += srgb_of(color[i]).y;
    voxels[static_cast<std::size_t>(tissue[i])] += 1;
  }
  const auto mean = [&](Tissue t) { return green[static_cast<std::size_t>(t)] / voxels[static_cast<std::size_t>(t)]; };
  EXPECT_GT(mean(Tissue::kEnamel), mean(Tissue::kDentin) + 0.15) << "the denser, the lighter";
  EXPECT_GT(mean(Tissue::kDentin), mean(Tissue::kPulp) + 0.05);
}

TEST(ImportCommand, OneOfSeveralSeriesIsImportedWithItsLabelsAndWithoutThePatientsName) {
  test::Phantom tooth;
  tooth.size = {30, 26, 28};
  tooth.spacing = dvec3(0.25);
  tooth.fine = 2;
  tooth.grey = [](const dvec3& q) {
    const double r = glm::length(q - dvec3(3.4, 3.1, 3.6));
    return r < 1.6 ? 830.0 : r < 2.4 ? 1220.0 : 400.0;
  };
  std::vector<test::DicomImage> images = test::slices_of(tooth.scan(), tooth.size, tooth.spacing);
  for (std::size_t k = 0; k < 28; ++k) {
    images.push_back(images[k]);
    images.back().series = "1.2.9", images.back().series_number = 2,
    images.back().instance = fmt::format("1.2.9.{}", k);
  }
  const auto folder = test::write_series("two", images), out = scratch("series.vdb"), labels = scratch("series.nii");
  const Ran asked = run(fmt::format("{} --out {}", folder.string(), out.string()));
  EXPECT_EQ(asked.status, 2);
  EXPECT_THAT(asked.err, testing::AllOf(HasSubstr("2 series"), HasSubstr("--series N")));
  const Ran ran = expect_ok(run(fmt::format("{} --series 2 --turn x180 --out {} --labels {} --json", folder.string(),
                                            out.string(), labels.string())));
  const Json report = Json::parse(ran.out, "report");
  EXPECT_EQ(report["input"].string(), "DICOM");
  EXPECT_EQ(report["labels"].string(), labels.string());
  EXPECT_EQ(test::read_text(labels).substr(344, 4), std::string("n+1\0", 4));
  for (const std::string& text : {ran.out, ran.err, test::read_text(out), test::read_text(labels)}) {
    for (const char* secret : {"HUSH", "HANNAH", test::kPatientId, test::kBirthDate})
      EXPECT_THAT(text, testing::Not(HasSubstr(secret)));
  }
}

TEST(ImportCommand, ResultsAreWrittenAsVolumesAndMeshesAtTheirPlaceInTheScan) {
  const std::string scan = "assets/teeth/molar.nhdr", scene = scratch("molar_scene.json").string();
  const auto report_of = [&](const std::string& arguments) {
    const Ran ran = program(arguments + " --json");
    EXPECT_EQ(ran.status, 0) << arguments << ran.err;
    return Json::parse(ran.out, "report");
  };
  const Json plain = report_of(fmt::format("import {} --voxel-mm 0.3 --out {}", scan, scratch("molar.vdb").string()));
  // The scene's tissue is turned and moved.
  report_of(fmt::format("import {} --voxel-mm 0.3 --turn x180 --out {}", scan, scene));
  const double volume = plain["volume_mm3"]["total"].number();
  const auto expect_at_place = [&](const Json& read) {
    for (std::size_t corner : {0U, 1U}) {
      for (std::size_t axis : {0U, 1U, 2U})
        EXPECT_NEAR(read["bounds_mm"].items()[corner].items()[axis].number(),
                    plain["bounds_mm"].items()[corner].items()[axis].number(), 0.2);
    }
    EXPECT_NEAR(read["volume_mm3"]["total"].number() / volume, 1, 0.05);
  };
  const std::string labels = scratch("of_scene.nrrd").string(), distances = scratch("of_scene_mm.nii").string();
  EXPECT_NEAR(
      report_of(fmt::format("volume {} --labels {} --distances {}", scene, labels, distances))["volume_mm3"]["enamel"]
          .number(),
      plain["volume_mm3"]["enamel"].number(), 0.01 * volume);
  expect_at_place(report_of(fmt::format("import {} --out {}", labels, scratch("again.vdb").string())));
  for (const char* ending : {"glb", "gltf", "stl", "obj", "ply"}) {
    SCOPED_TRACE(ending);
    const std::string mesh = scratch(std::string("of_scene.") + ending).string();
    report_of(fmt::format("mesh {} --file-space --out {}", scene, mesh));
    const bool metres = std::string(ending).starts_with("gl");
    expect_at_place(report_of(fmt::format("import {} --voxel-mm 0.3 {} --out {}", mesh, metres ? "--unit-mm 1000" : "",
                                          scratch("again.vdb").string())));
  }
  expect_exit(program("volume " + scene), 2, "--labels FILE, --distances FILE or both");
  const Ran wrong = program(fmt::format("volume {} --distances {}", scene, scratch("wrong.dcm").string()));
  EXPECT_EQ(wrong.status, 2);
  EXPECT_FALSE(std::filesystem::exists(scratch("wrong.dcm")));
}

TEST(ImportCommand, BadInputExitsWithTwoAndWritesNothing) {
  const std::string out = scratch("never.vdb").string();
  const auto expect_refused = [&](const std::string& arguments, const std::string& message) {
    const Ran ran = expect_exit(run(arguments), 2, message);
    EXPECT_EQ(ran.out, "");
    EXPECT_FALSE(std::filesystem::exists(out));
  };
  expect_refused("nowhere.nrrd --out " + out, "nowhere.nrrd: found No such file");
  expect_refused("assets/teeth/molar.nhdr --spacing-mm 1 --out " + out, "--spacing-mm");
  expect_refused("assets/teeth/molar.nhdr --spacing-mm 0.1,abc --out " + out, "--spacing-mm");
  expect_refused("assets/teeth/molar.nhdr --thresholds 1000,600 --out " + out, "--thresholds");
  expect_refused("assets/teeth/molar.nhdr --hardness-greys 800 --out " + out, "--hardness-greys");
  expect_refused("assets/teeth/molar.nhdr --hardness-greys 800,400 --out " + out, "--hardness-greys");
  expect_refused("assets/teeth/molar.nhdr --color-greys 800,400 --out " + out, "--color-greys");
  expect_refused("assets/teeth/molar.nhdr --voxel-mm 0.01 --out " + out, "--voxel-mm");
  expect_refused("assets/teeth/molar.nhdr --out /no/such/folder/x.vdb", "--out");
  expect_refused("assets/teeth/molar.nhdr --preset hair --out " + out, "preset");
}

}  // namespace
}  // namespace typodont::haptics
