// Tests a school's key through the command line: sign, verify by replay, report, and several attempts to forge a
// signature.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "engine/base/json.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using namespace test;
using testing::HasSubstr;

class SignCommand : public testing::Test {
 protected:
  SignCommand() {
    folder.write("scene.json", R"({"tissue": {"voxel_mm": 0.2, "solids": [
      {"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]}, "tool": {"shape": "sphere", "diameter_mm": 1.0}})");
    folder.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,4,1,0,0,0,0\n0.2,0,0,3,1,0,0,0,1\n");
    const Ran ran = run("servo {}/scene.json --hand {}/hand.csv --out {}/s.h5");
    EXPECT_EQ(ran.status, 0) << ran.err;
    EXPECT_EQ(run("sign --new-key {}/school.key").status, 0);
  }
  Ran run(std::string arguments) const {
    for (std::size_t at; (at = arguments.find("{}")) != std::string::npos;)
      arguments.replace(at, 2, folder.path().string());
    return folder.run(arguments, "timeout 120");
  }
  void refused(const std::string& arguments, int status, const std::string& message) const {
    const Ran ran = run(arguments);
    EXPECT_EQ(ran.status, status) << arguments << "\n" << ran.err;
    EXPECT_THAT(ran.err, HasSubstr(message)) << arguments;
  }
  ProgramFolder folder{TYPODONT_PROGRAM};
};

TEST_F(SignCommand, ASignedSessionIsVerifiedByReplayAndReport) {
  refused("replay {}/s.h5 --check --key {}/school.key", 1, "no signature");
  refused("report {}/s.h5 --out {}/r.html --key {}/school.key", 1, "no signature");
  EXPECT_FALSE(std::filesystem::exists(folder / "r.html"));
  const Ran signed_ = run("sign --key {}/school.key {}/s.h5");
  ASSERT_EQ(signed_.status, 0) << signed_.err;
  EXPECT_THAT(signed_.out, HasSubstr("s.h5.sig: signed with key "));
  const Ran replay = run("replay {}/s.h5 --check --json --key {}/school.key");
  ASSERT_EQ(replay.status, 0) << replay.err;
  EXPECT_EQ(Json::parse(replay.out, "replay")["signature"].string(), "valid");
  const Ran report = run("report {}/s.h5 --out {}/r.html --json --key {}/school.key");
  ASSERT_EQ(report.status, 0) << report.err;
  EXPECT_EQ(Json::parse(report.out, "report")["signature"].string(), "valid");
  // Reading it changed nothing.
  EXPECT_EQ(run("replay {}/s.h5 --check --key {}/school.key").status, 0);
}

TEST_F(SignCommand, AForgedSessionOrAWrongKeyIsRefusedBeforeTheFileIsParsed) {
  ASSERT_EQ(run("sign --key {}/school.key {}/s.h5").status, 0);
  ASSERT_EQ(run("sign --new-key {}/students.key").status, 0);
  refused("replay {}/s.h5 --check --key {}/students.key", 1, "the signature is of another key");
  std::string bytes = read_text(folder / "s.h5");
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  folder.write("s.h5", bytes);
  refused("replay {}/s.h5 --check --key {}/school.key", 1, "the file changed after it was signed");
  refused("report {}/s.h5 --out {}/r.html --key {}/school.key", 1, "the file changed after it was signed");
  EXPECT_FALSE(std::filesystem::exists(folder / "r.html"));
}

TEST_F(SignCommand, UsageErrorsAreNamed) {
  refused("sign {}/s.h5", 2, "expected --key FILE SESSION.h5");
  refused("sign --new-key {}/school.key", 2, "expected a new file for the key");
  refused("sign --key {}/scene.json {}/s.h5", 2, "scene.json");
  refused("sign --key {}/school.key {}/hand.csv", 2, "hand.csv");
  EXPECT_FALSE(std::filesystem::exists(folder / "hand.csv.sig"));
  std::filesystem::permissions(folder / "school.key", std::filesystem::perms::group_read,
                               std::filesystem::perm_options::add);
  refused("sign --key {}/school.key {}/s.h5", 2, "a key that others may read");
}

}  // namespace
}  // namespace typodont
