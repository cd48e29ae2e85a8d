// Tests a school's key through the command line: sign, verify by replay, report, and several attempts to forge a
// signature.
#include <gmock/gmock.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "engine/base/fnv.h"
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
    expect_ok(run("servo {}/scene.json --hand {}/hand.csv --out {}/s.h5"));
    EXPECT_EQ(run("sign --new-key {}/school.key").status, 0);
  }
  Ran run(const std::string& arguments) const { return folder.run(arguments, "timeout 120"); }
  void refused(const std::string& arguments, int status, const std::string& message) const {
    expect_exit(run(arguments), status, message);
  }
  ProgramFolder folder{TYPODONT_PROGRAM};
};

TEST_F(SignCommand, ASignedSessionIsVerifiedByReplayAndReport) {
  refused("replay {}/s.h5 --check --key {}/school.key", 1, "no signature");
  refused("report {}/s.h5 --out {}/r.html --key {}/school.key", 1, "no signature");
  EXPECT_FALSE(std::filesystem::exists(folder / "r.html"));
  const Ran signed_ = expect_ok(run("sign --key {}/school.key {}/s.h5"));
  EXPECT_THAT(signed_.out, HasSubstr("s.h5.sig: signed with key "));
  const Ran replay = expect_ok(run("replay {}/s.h5 --check --json --key {}/school.key"));
  EXPECT_EQ(Json::parse(replay.out, "replay")["signature"].string(), "valid");
  const Ran report = expect_ok(run("report {}/s.h5 --out {}/r.html --json --key {}/school.key"));
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

TEST_F(SignCommand, AForgedJournalBesideASignedSessionChangesNoCommandsResult) {
  folder.write("other.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,4,1,0,0,0,0\n0.3,0,0,2.5,1,0,0,0,1\n");
  ASSERT_EQ(run("servo {}/scene.json --hand {}/other.csv --out {}/forged.h5").status, 0);
  ASSERT_EQ(run("sign --key {}/school.key {}/s.h5").status, 0);
  const std::string commands[] = {
      "replay {}/s.h5 --check --json --key {}/school.key", "report {}/s.h5 --json --out {}/r.html --key {}/school.key",
      "mesh {}/s.h5 --json --out {}/m.ply", "render {}/s.h5 --at 0.2 --magnify 8 --size 64x64 --out {}/p",
      "rescore {}/s.h5 --json"};
  const std::string bytes = read_text(folder / "s.h5"), forged = read_text(folder / "forged.h5");
  std::vector<std::string> without;
  for (const std::string& command : commands) without.push_back(run(command).out);
  const std::string picture = read_text(folder / "p/screen.png");
  const auto number = [](std::uint64_t n) { return std::string(reinterpret_cast<const char*>(&n), sizeof n); };
  const std::string change = number(0) + number(forged.size()) + forged;
  for (const std::string& begin :
       {std::string("TYPOJRN1"), "TYPOJRN2" + std::string(32, 'a') + number(bytes.size()) + number(forged.size())}) {
    const std::string head = begin + number(change.size());
    Fnv1a hash;
    if (begin.size() > 8) hash.bytes(head.data(), head.size());
    hash.bytes(change.data(), change.size());
    folder.write("s.h5.journal", head + number(hash.value) + change);
    for (std::size_t i = 0; i < std::size(commands); ++i) {
      const Ran ran = expect_ok(run(commands[i]));
      EXPECT_EQ(ran.out, without[i]) << commands[i];
      EXPECT_EQ(read_text(folder / "s.h5"), bytes) << commands[i];
    }
    EXPECT_EQ(read_text(folder / "p/screen.png"), picture);
    refused("repair {}/s.h5", 2, "a signed session");
  }
}

TEST_F(SignCommand, ASessionThatIsSwappedWhileItIsReportedIsTheSignedOneOrRefused) {
  folder.write("other.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,4,1,0,0,0,0\n0.3,0,0,2.5,1,0,0,0,1\n");
  ASSERT_EQ(run("servo {}/scene.json --hand {}/other.csv --out {}/forged.h5").status, 0);
  ASSERT_EQ(run("sign --key {}/school.key {}/s.h5").status, 0);
  const double ticks = Json::parse(run("report {}/s.h5 --json --out {}/r.html").out, "report")["ticks"].number();
  std::filesystem::copy_file(folder / "s.h5", folder / "signed.h5");
  std::atomic<bool> stop{false};
  std::jthread swapper([&] {
    std::mt19937 random(3);
    while (!stop) {
      for (const char* name : {"forged.h5", "signed.h5"}) {
        std::filesystem::copy_file(folder / name, folder / "next.h5",
                                   std::filesystem::copy_options::overwrite_existing);
        std::filesystem::rename(folder / "next.h5", folder / "s.h5");
        std::this_thread::sleep_for(std::chrono::milliseconds(random() % 20));
      }
    }
  });
  int accepted = 0;
  for (int i = 0; i < 200 && accepted < 3; ++i) {
    const Ran ran = run("report {}/s.h5 --json --out {}/r.html --verify --key {}/school.key");
    if (ran.status != 0) {
      EXPECT_EQ(ran.status, 1) << ran.err;
      continue;
    }
    ++accepted;
    EXPECT_EQ(Json::parse(ran.out, "report")["ticks"].number(), ticks);
  }
  stop = true;
  EXPECT_EQ(accepted, 3);
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
