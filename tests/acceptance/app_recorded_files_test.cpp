// Tests how a recording finds the files of its scene again.
#include <gmock/gmock.h>

#include <filesystem>
#include <string>

#include "engine/app/recording/replay.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/session/session_file.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using namespace test;
using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

/// A session with a volume in a folder that has a patient's name.
class RecordedFiles : public testing::Test {
 protected:
  RecordedFiles() {
    for (const auto& [name, radius] : {std::pair("tooth", 3.0), std::pair("other", 2.5)}) {
      folder.write("solid.json", fmt::format(R"({{"tissue": {{"voxel_mm": 0.2, "solids": [{{"tissue": "enamel",
        "solid": {{"sphere": {{"radius_mm": {}}}}}}}]}}, "tool": "round_012"}})",
                                             radius));
      folder.write("rest.csv", std::string(kColumns) + "0,0,0,5,1,0,0,0,0\n0.01,0,0,5,1,0,0,0,0\n");
      expect_ok(folder.run(
          fmt::format("servo {{}}/solid.json --hand {{}}/rest.csv --out {{}}/none.h5 --save {{}}/{}.vdb", name)));
    }
    fs::create_directories(volume.parent_path());
    fs::rename(folder / "tooth.vdb", volume);
    folder.write("anna/scene.json",
                 fmt::format(R"({{"tissue": {{"volume": "{}"}}, "tool": {{"shape": "sphere", "diameter_mm": 1.0}},
      "task": {{"goal": "a pit", "ideal": {{"volume": "scans/tooth.vdb"}}}}}})",
                             volume.string()));
    folder.write("anna/hand.csv", std::string(kColumns) + "0,0,0,5,1,0,0,0,1\n0.3,0,0,2.8,1,0,0,0,1\n");
    expect_ok(folder.run("servo {}/anna/scene.json --hand {}/anna/hand.csv --out {}/anna/s.h5"));
  }

  static constexpr const char* kColumns = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";
  ProgramFolder folder{TYPODONT_PROGRAM};
  const fs::path volume = folder.path() / "anna/scans/tooth.vdb";
};

TEST_F(RecordedFiles, AreFoundByTheirContentAndNameNoFolder) {
  const session::SessionHeader header = session::SessionReader(folder / "anna/s.h5").header();
  std::string texts = header.scene_json + header.rig_json + header.hand;
  for (const session::SourceFile& file : header.files) texts += file.path + "\n";
  EXPECT_THAT(texts, HasSubstr("tooth.vdb"));
  EXPECT_THAT(texts, HasSubstr("hand.csv"));
  for (const char* name : {"anna", "scans", "typodont_test"}) EXPECT_THAT(texts, Not(HasSubstr(name)));
  fs::rename(folder.path() / "anna", folder.path() / "pseudonym");
  fs::rename(folder.path() / "pseudonym/scans/tooth.vdb", folder.path() / "pseudonym/scans/47.vdb");
  expect_ok(folder.run("replay {}/pseudonym/s.h5 --check"));
  // Away from its files, the recording finds them in the user's folder and in the current folder.
  fs::create_directory(folder.path() / "elsewhere");
  fs::rename(folder.path() / "pseudonym/s.h5", folder.path() / "elsewhere/s.h5");
  const std::string check = "replay {}/elsewhere/s.h5 --check";
  EXPECT_EQ(folder.run(check).status, 2);
  EXPECT_EQ(folder.run(check, fmt::format("env TYPODONT_HOME={}/pseudonym", folder.path().string())).status, 0);
  EXPECT_EQ(folder.run(check, fmt::format("cd {}/pseudonym &&", folder.path().string())).status, 0);
}

TEST_F(RecordedFiles, AFileThatIsSwappedAfterItsCheckIsNotRead) {
  const session::SessionReader session(folder / "anna/s.h5");
  const Scene scene = scene_of(session);
  const std::uint64_t recorded = load_tissue(read_scene(folder / "anna/scene.json")).hash();
  fs::copy_file(folder / "other.vdb", volume, fs::copy_options::overwrite_existing);
  EXPECT_NE(load_tissue(read_scene(folder / "anna/scene.json")).hash(), recorded);
  EXPECT_EQ(load_tissue(scene).hash(), recorded) << "the copy that was checked";
  EXPECT_THAT(test::refusal([&] { (void)scene_of(session); }),
              HasSubstr("tooth.vdb: found another content, expected sha256:"));
}

}  // namespace
}  // namespace typodont
