// Tests session files that were made to do harm: they refer to other files, or state impossible values.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <span>

#include "engine/session/recorder.h"
#include "engine/session/session_file.h"
#include "tests/support/hdf5_edit.h"
#include "tests/support/session_fixture.h"

namespace typodont::session {
namespace {

using namespace test;
using testing::HasSubstr;

constexpr const char* kSecret = "the content of another file of this machine, which nobody may see";

/// A complete session file with 600 ticks, 40 cuts, 4 patches and two events.
class HostileFile : public testing::Test {
 protected:
  HostileFile() {
    SessionWriter writer(file_, some_header());
    writer.append(random_patches(4, 3));
    writer.append(random_cuts(40, 2));
    auto ticks = random_ticks(600, 1);
    for (ServoTick& tick : ticks) tick.cuts = std::min<std::uint64_t>(tick.index / 10, 40);
    writer.append(ticks);
    writer.event(1, EventKind::kNote, "a note");
    EXPECT_TRUE(writer.finish({})) << writer.status().message;
    std::ofstream(secret_) << std::string(kSecret) + std::string(4096, 's');
  }

  template <class Work>
  void change(Work&& work) {
    typodont::test::change_hdf5(file_, work);
  }

  std::string message() const {
    return refusal([&] { (void)SessionReader(file_).ticks(); });
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "s.h5", secret_ = folder_ / "secret";
};

TEST_F(HostileFile, AnUnchangedFileIsReadable) {
  EXPECT_EQ(message(), "");
  EXPECT_TRUE(SessionReader(file_).gaps().empty());
}

TEST_F(HostileFile, DataKeptInAnotherFileIsRefusedAndNotShown) {
  std::filesystem::copy_file(file_, folder_ / "good.h5");
  for (const char* path : {"events/text", "header/scene", "ticks/t_ns", "result/field_hash", "complete", "lost"}) {
    std::filesystem::copy_file(folder_ / "good.h5", file_, std::filesystem::copy_options::overwrite_existing);
    change([&](hid_t h5) {
      H5Ldelete(h5, path, H5P_DEFAULT);
      const hid_t properties = H5Pcreate(H5P_DATASET_CREATE), type = H5Tcopy(H5T_C_S1);
      H5Tset_size(type, 256);
      H5Pset_external(properties, secret_.c_str(), 0, 256);
      const hsize_t one = 1;
      const hid_t space = H5Screate_simple(1, &one, nullptr);
      H5Dclose(H5Dcreate2(h5, path, type, space, H5P_DEFAULT, properties, H5P_DEFAULT));
      H5Sclose(space), H5Tclose(type), H5Pclose(properties);
    });
    EXPECT_THAT(message(), HasSubstr("data kept in another file")) << path;
    EXPECT_THAT(message(), testing::Not(HasSubstr("the content of")));
  }
}

TEST_F(HostileFile, LinksAreRefusedAnywhereInAPath) {
  std::filesystem::copy_file(file_, folder_ / "other.h5");
  for (const std::string path : {"events", "events/text", "header", "header/scene", "streams", "ticks", "cuts/index",
                                 "loop", "pictures/png", "result"}) {
    std::filesystem::copy_file(folder_ / "other.h5", file_, std::filesystem::copy_options::overwrite_existing);
    change([&](hid_t h5) {
      H5Ldelete(h5, path.c_str(), H5P_DEFAULT);
      H5Lcreate_external("other.h5", path.c_str(), h5, path.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    });
    EXPECT_THAT(message(), HasSubstr("a link to another file")) << path;
    std::filesystem::copy_file(folder_ / "other.h5", file_, std::filesystem::copy_options::overwrite_existing);
    change([&](hid_t h5) {
      H5Lmove(h5, path.c_str(), h5, "elsewhere", H5P_DEFAULT, H5P_DEFAULT);
      H5Lcreate_soft("/elsewhere", h5, path.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    });
    EXPECT_THAT(message(), HasSubstr("a soft link")) << path;
  }
}

TEST_F(HostileFile, AVirtualDatasetIsRefused) {
  std::filesystem::copy_file(file_, folder_ / "other.h5");
  change([&](hid_t h5) {
    H5Ldelete(h5, "ticks/force_x_N", H5P_DEFAULT);
    const hsize_t rows = 600;
    const hid_t space = H5Screate_simple(1, &rows, nullptr), properties = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_virtual(properties, space, (folder_ / "other.h5").c_str(), "ticks/force_x_N", space);
    H5Dclose(H5Dcreate2(h5, "ticks/force_x_N", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, properties, H5P_DEFAULT));
    H5Sclose(space), H5Pclose(properties);
  });
  EXPECT_THAT(message(), HasSubstr("a virtual dataset"));
}

TEST_F(HostileFile, AFilterThatSessionsDoNotHaveIsRefused) {
  change([&](hid_t h5) {
    H5Ldelete(h5, "cuts/t_ns", H5P_DEFAULT);
    const hsize_t rows = 40;
    const hid_t space = H5Screate_simple(1, &rows, nullptr), properties = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(properties, 1, &rows);
    H5Pset_nbit(properties);
    H5Dclose(H5Dcreate2(h5, "cuts/t_ns", H5T_NATIVE_INT64, space, H5P_DEFAULT, properties, H5P_DEFAULT));
    H5Sclose(space), H5Pclose(properties);
  });
  EXPECT_THAT(message(), HasSubstr("filter 5"));
}

TEST_F(HostileFile, RowsThatWereNeverWrittenAreNotRead) {
  change([&](hid_t h5) {
    const hsize_t many = hsize_t{1} << 33;
    for (const char* column : {"cuts/index", "events/kind", "streams/sound/t_ns"}) {
      const hid_t dataset = H5Dopen2(h5, column, H5P_DEFAULT);
      H5Dset_extent(dataset, &many);
      H5Dclose(dataset);
    }
  });
  EXPECT_THAT(message(), HasSubstr("cuts/index"));
}

TEST_F(HostileFile, AHugeTextThatTheFileDoesNotHoldIsRefused) {
  change([&](hid_t h5) {
    H5Ldelete(h5, "header/scene", H5P_DEFAULT);
    const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
    H5Tset_size(type, std::size_t{3} << 30);
    H5Dclose(H5Dcreate2(h5, "header/scene", type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    H5Sclose(space), H5Tclose(type);
  });
  EXPECT_THAT(message(), HasSubstr("more bytes than the file has"));
}

TEST_F(HostileFile, EveryImpossibleValueIsNamedWithItsPlace) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  std::filesystem::copy_file(file_, folder_ / "good.h5");
  const auto expect = [&](const std::string& path, hsize_t row, auto value, const std::string& words) {
    std::filesystem::copy_file(folder_ / "good.h5", file_, std::filesystem::copy_options::overwrite_existing);
    typodont::test::set_hdf5(file_, path, row, value);
    EXPECT_THAT(message(), HasSubstr(words)) << path << " = " << value;
  };
  expect("cuts/index", 7, std::uint64_t{3}, "cuts, row 7, index: found 3, expected above 7");
  expect("cuts/index", 0, std::uint64_t{0}, "cuts, row 0, index");
  expect("cuts/tick", 7, std::uint64_t{1}, "cuts, row 7, tick");
  expect("cuts/tool", 7, std::uint32_t{3}, "cuts, row 7, tool: found 3, expected one of the session's 3 tools");
  for (const double radius : {1.0, 1e300, -1e-3, nan, inf})
    expect("cuts/fill_radius_m", 5, radius, "cuts, row 5, fill_radius_m");
  for (const double x : {1e6, nan, inf}) {
    expect("cuts/a_x_m", 3, x, "cuts, row 3, a_*");
    expect("cuts/b_z_m", 3, x, "cuts, row 3, b_*");
    expect("patches/center_y_m", 1, x, "patches, row 1, center_*_m");
    expect("ticks/tool_x_mm", 9, x * 1e3, "ticks, row 9, tool_*");
    expect("ticks/force_y_N", 9, x, "ticks, row 9, force_*_N");
    expect("ticks/removed_dentin_mm3", 9, x * 1e9, "ticks, row 9, removed_*_mm3");
  }
  expect("cuts/b_x_m", 3, 0.3, "cuts, row 3, from a to b, m");
  expect("cuts/a_qw", 3, 4.0, "a quaternion of length");
  expect("cuts/t_ns", 3, std::int64_t{1} << 62, "cuts, row 3, t_ns");
  expect("patches/patch", 2, std::uint32_t{1}, "patches, row 2, patch");
  expect("patches/first_tick", 2, std::uint64_t{0}, "patches, row 2, first_tick");
  expect("ticks/index", 9, std::uint64_t{2}, "ticks, row 9, index");
  expect("ticks/cuts", 300, std::uint64_t{0}, "ticks, row 300, cuts");
  expect("ticks/tool", 9, std::uint32_t{17}, "ticks, row 9, tool");
  expect("ticks/t_ns", 9, std::int64_t{1} << 62, "ticks, row 9, t_ns");
  expect("events/t_ns", 0, std::int64_t{1} << 62, "events, row 0, t_ns");
  expect("header/volumes_before_mm3", 1, nan, "header/volumes_before_mm3");
}

TEST(GapOfARecording, IsNamedWithItsPlaceAndWhatIsMissingAndTheRestIsRead) {
  TemporaryFolder folder;
  auto ticks = random_ticks(9000, 4);
  for (ServoTick& tick : ticks) tick.cuts = tick.index / 10;
  const auto cuts = random_cuts(899, 5);
  {
    SessionWriter writer(folder / "s.h5", some_header());
    writer.append(std::span(cuts).first(200));
    writer.append(std::span(cuts).subspan(800));
    writer.append(std::span(ticks).first(2000));
    writer.append(std::span(ticks).subspan(8005));
    ASSERT_TRUE(writer.finish({}));
  }
  const SessionReader reader(folder / "s.h5");
  EXPECT_EQ(reader.tick_count(), 2995u);
  EXPECT_EQ(reader.cuts().size(), 299u);
  ASSERT_EQ(reader.gaps().size(), 1u);
  EXPECT_EQ(reader.gaps()[0].after_tick, 1999u);
  EXPECT_EQ(reader.gaps()[0].ticks, 6005u);
  EXPECT_EQ(reader.gaps()[0].cuts, 600u);
  EXPECT_EQ(in_words(reader.gaps()), "1.999 s to 8.005 s (6005 ticks, 600 cuts)");
}

TEST(GapOfARecording, IsSeenAlsoWhereOnlyCutsWereLost) {
  TemporaryFolder folder;
  auto ticks = random_ticks(1000, 4);
  for (ServoTick& tick : ticks) tick.cuts = std::min<std::uint64_t>(tick.index / 3, 60);
  const auto cuts = random_cuts(60, 5);
  {
    SessionWriter writer(folder / "s.h5", some_header());
    writer.append(std::span(cuts).first(20));
    writer.append(std::span(cuts).subspan(25, 30));
    writer.append(ticks);
    ASSERT_TRUE(writer.finish({}));
  }
  const SessionReader reader(folder / "s.h5");
  ASSERT_EQ(reader.gaps().size(), 2u) << in_words(reader.gaps());
  EXPECT_EQ(reader.gaps()[0].ticks, 0u);
  EXPECT_EQ(reader.gaps()[0].cuts, 5u);
  EXPECT_EQ(reader.gaps()[1].cuts, 5u) << "of the last cuts the ticks tell";
}

}  // namespace
}  // namespace typodont::session
