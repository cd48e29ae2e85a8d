// Changes session files with HDF5's own functions, so that every checksum is right.
#pragma once

#include <gtest/gtest.h>
#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <type_traits>

namespace typodont::test {

/// `work` gets the open file.
template <class Work>
void change_hdf5(const std::filesystem::path& file, Work&& work) {
  const hid_t h5 = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  ASSERT_GE(h5, 0);
  work(h5);
  ASSERT_GE(H5Fclose(h5), 0);
}

/// Sets one row of a column.
template <class T>
void set_hdf5(const std::filesystem::path& file, const std::string& path, hsize_t row, T value) {
  change_hdf5(file, [&](hid_t h5) {
    const hid_t dataset = H5Dopen2(h5, path.c_str(), H5P_DEFAULT), space = H5Dget_space(dataset);
    const hsize_t one = 1;
    const hid_t memory = H5Screate_simple(1, &one, nullptr);
    H5Sselect_hyperslab(space, H5S_SELECT_SET, &row, nullptr, &one, nullptr);
    hid_t type = H5T_NATIVE_DOUBLE;
    if constexpr (std::is_same_v<T, std::uint64_t>) type = H5T_NATIVE_UINT64;
    if constexpr (std::is_same_v<T, std::int64_t>) type = H5T_NATIVE_INT64;
    if constexpr (std::is_same_v<T, std::uint32_t>) type = H5T_NATIVE_UINT32;
    EXPECT_GE(H5Dwrite(dataset, type, memory, space, H5P_DEFAULT, &value), 0);
    H5Sclose(memory), H5Sclose(space), H5Dclose(dataset);
  });
}

}  // namespace typodont::test
