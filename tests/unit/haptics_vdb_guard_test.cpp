// Tests volume files that are damaged at any position.
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>

#include "engine/base/error.h"
#include "engine/base/json.h"
#include "haptics/solid.h"
#include "haptics/tissue_volume.h"
#include "haptics/volume/vdb_guard.h"
#include "tests/support/program.h"

namespace typodont::haptics {
namespace {

using test::read_text;
using testing::HasSubstr;

class VdbGuard : public testing::Test {
 protected:
  VdbGuard() {
    TissueVolume(
        read_solids(Json::parse(
            R"({"voxel_mm": 0.5, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]})", "x")))
        .save(file_);
    bytes_ = read_text(file_);
  }
  void write(const std::string& bytes) const {
    std::filesystem::remove(file_);
    std::ofstream(file_, std::ios::binary) << bytes;
  }
  std::string message() const {
    return test::refusal([&] { (void)TissueVolume::load(file_); });
  }
  static constexpr std::size_t kSealBytes = 16;
  const test::Folder folder_;
  const std::filesystem::path file_ = folder_ / "sphere.vdb";
  std::string bytes_;
};

TEST_F(VdbGuard, AnyChangedByteOfASealedFileIsNoticed) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 200; ++i) {
    std::string damaged = bytes_;
    char& byte = damaged[random() % (damaged.size() - kSealBytes)];
    byte = static_cast<char>(byte ^ static_cast<char>(1 + random() % 255));
    write(damaged);
    EXPECT_THAT(message(), HasSubstr("changed since it was written"));
  }
}

TEST_F(VdbGuard, WithoutRoomForACopyAnIntactVolumeIsNotReportedAsDamaged) {
  // The process that reads the volume reports the reason by its exit status. Here it is a full disk: nothing can be
  // written to /dev/full.
  const std::string reader =
      (std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path() / "typodont-openvdb").string();
  ASSERT_TRUE(std::filesystem::exists(reader)) << reader;
  const int status =
      std::system(fmt::format("{} read {} /dev/full distance >/dev/null 2>&1", reader, file_.string()).c_str());
  EXPECT_EQ(WEXITSTATUS(status), 3);
  // The program must show the same reason if its temporary folder is full.
  const std::string cache = folder_ / "cache";  // an empty one: what is kept needs no copy
  ::setenv("TYPODONT_CACHE", cache.c_str(), 1);
  const std::string stand_in = folder_ / "reader";
  std::ofstream(stand_in) << "#!/bin/sh\nexit 3\n";
  std::filesystem::permissions(stand_in, std::filesystem::perms::owner_all);
  ::setenv("TYPODONT_OPENVDB", stand_in.c_str(), 1);
  const std::string said = message();
  ::unsetenv("TYPODONT_OPENVDB");
  EXPECT_THAT(said, testing::AllOf(HasSubstr("no room for a copy of " + file_.string()), HasSubstr("TMPDIR"),
                                   testing::Not(HasSubstr("damaged"))));
  EXPECT_EQ(message(), "");  // when the disk has space again
  ::unsetenv("TYPODONT_CACHE");
}

TEST_F(VdbGuard, UnderASmallLimitOfTheFileSizeAnIntactVolumeIsNotReportedAsDamaged) {
  const std::string cache = folder_ / "cache";
  ::setenv("TYPODONT_CACHE", cache.c_str(), 1);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{4096, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string said = message();
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_THAT(said, testing::AllOf(HasSubstr("no room for a copy"), testing::Not(HasSubstr("damaged"))));
  ::unsetenv("TYPODONT_CACHE");
}

/// Time and memory of a session grow with the box around the tissue. Before volumes were checked, one far voxel cost 45
/// s and 7 GB.
TEST_F(VdbGuard, AVolumeWithAFarVoxelIsRefused) {
  openvdb::initialize();
  openvdb::io::File in(file_.string());
  in.setCopyMaxBytes(0);
  in.open(false);
  const auto distance = openvdb::gridPtrCast<openvdb::FloatGrid>(in.readGrid("distance"));
  const auto tissue = openvdb::gridPtrCast<openvdb::Int32Grid>(in.readGrid("tissue"));
  in.close();
  const auto message_with = [&](const std::function<void(openvdb::FloatGrid&, openvdb::Int32Grid&)>& change) {
    const openvdb::GridCPtrVec grids{distance->deepCopy(), tissue->deepCopy()};
    change(*std::const_pointer_cast<openvdb::FloatGrid>(openvdb::gridConstPtrCast<openvdb::FloatGrid>(grids[0])),
           *std::const_pointer_cast<openvdb::Int32Grid>(openvdb::gridConstPtrCast<openvdb::Int32Grid>(grids[1])));
    openvdb::io::File(file_.string()).write(grids);
    return message();
  };
  for (const openvdb::Coord far : {openvdb::Coord(10'000'000, 0, 0), openvdb::Coord(900, -900, 900)}) {
    EXPECT_THAT(message_with([&](auto& field, auto&) { field.tree().setValue(far, 0.1f); }), HasSubstr("spread over"));
    EXPECT_THAT(message_with([&](auto&, auto& labels) { labels.tree().setValue(far, 1); }), HasSubstr("spread over"));
  }
  // a tile of 4096³ voxels
  EXPECT_THAT(
      message_with([](auto& field, auto&) { field.tree().addTile(3, openvdb::Coord(0, 0, 4096), -1.5f, true); }),
      HasSubstr("spread over"));
  EXPECT_THAT(message_with([](auto&, auto& labels) { labels.tree().addTile(3, openvdb::Coord(0, 0, 4096), 1, true); }),
              HasSubstr("spread over"));
  // A volume with two pieces of tissue is accepted if the distance between them is that of two teeth.
  EXPECT_EQ(message_with([](auto& field, auto& labels) {
              field.tree().setValue(openvdb::Coord(200, 0, 0), 0.1f);
              labels.tree().setValue(openvdb::Coord(200, 0, 0), 1);
            }),
            "");
}

TEST_F(VdbGuard, AForeignFileWithoutASealIsRead) {
  write(bytes_);
  const std::uint64_t sealed = TissueVolume::load(file_).hash();
  EXPECT_EQ(TissueVolume::load(file_).hash(), sealed) << "from the cache";
  write(bytes_.substr(0, bytes_.size() - kSealBytes));
  EXPECT_EQ(TissueVolume::load(file_).hash(), sealed);
}

TEST_F(VdbGuard, ATruncatedUnsealedFileIsRefused) {
  for (std::size_t size = 0; size < bytes_.size() - kSealBytes; size += 97) {
    write(bytes_.substr(0, size));
    EXPECT_NE(message(), "") << size;
  }
}

TEST_F(VdbGuard, ALengthBeyondTheFileIsNamed) {
  std::string damaged = bytes_.substr(0, bytes_.size() - kSealBytes);
  const std::size_t name =
      damaged.find("Tree_float");  // the type of the first grid, its length in the four bytes before
  ASSERT_NE(name, std::string::npos);
  damaged[name - 1] = '\x7f';
  write(damaged);
  EXPECT_THAT(message(), HasSubstr("type of a grid"));
}

/// Changes the file and computes the seal again, as an attacker would.
TEST_F(VdbGuard, AForgedSealCannotCrashTheProgram) {
  std::mt19937_64 random(8);
  int refused = 0;
  constexpr int kFiles = 80;
  for (int i = 0; i < kFiles; ++i) {
    std::string damaged = bytes_.substr(0, bytes_.size() - kSealBytes);
    for (std::uint64_t k = 0; k < 1 + random() % 3; ++k) {
      char& byte = damaged[random() % damaged.size()];
      byte = static_cast<char>(byte ^ static_cast<char>(1 << random() % 8));
    }
    write(damaged);
    if (i % 2) seal_vdb(file_);
    refused += !message().empty();  // what it does instead of an Error ends this test program
  }
  EXPECT_GT(refused, kFiles / 10);
}

TEST_F(VdbGuard, TheProcessThatReadsHasLittleMemory) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's own memory has no limit (guarded_process.cpp)";
#endif
  // Writes huge numbers in place of every length of every block. The file would then need a thousand times the memory
  // that a file of its size may need.
  std::string damaged = bytes_.substr(0, bytes_.size() - kSealBytes);
  const std::size_t tree = damaged.find("background");
  for (std::size_t at = tree == std::string::npos ? 200 : tree; at + 4 < damaged.size() && at < 3000; at += 127) {
    std::string huge = damaged;
    for (std::size_t i = 0; i < 4; ++i) huge[at + i] = i == 3 ? '\x3f' : '\xff';
    write(huge);
    seal_vdb(file_);
    (void)message();
  }
  rusage children{};
  getrusage(RUSAGE_CHILDREN, &children);
  EXPECT_LT(children.ru_maxrss, 1 << 20) << "kilobytes, of the largest of all processes that read";
}

TEST_F(VdbGuard, ATruncatedOrChangedBlockListCannotCrashTheProgram) {
  const std::vector<std::string> names = {"distance", "tissue"};
  const FlatGrids grids = read_guarded(file_, names);
  const auto flat = folder_ / "flat";
  const int fd = open(flat.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  write_flat(fd, "flat", grids);
  close(fd);
  const std::string bytes = read_text(flat);
  std::mt19937_64 random(3);
  for (int i = 0; i < 300; ++i) {
    std::string damaged = i % 2 ? bytes.substr(0, random() % bytes.size()) : bytes;
    for (int k = 0; k < 4 && !damaged.empty(); ++k)
      damaged[random() % std::min<std::size_t>(damaged.size(), i % 4 ? 200 : bytes.size())] =
          static_cast<char>(random());
    std::ofstream(flat, std::ios::binary | std::ios::trunc) << damaged;
    try {
      (void)read_flat_grids(flat, "flat");
      EXPECT_EQ(damaged.size(), bytes.size());
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr("flat"));
    }
  }
}

}  // namespace
}  // namespace typodont::haptics
