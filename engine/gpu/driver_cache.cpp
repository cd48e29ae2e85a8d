#include "engine/gpu/driver_cache.h"

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <mutex>
#include <set>
#include <sstream>
#include <string>
#include <utility>

#include "engine/base/cache.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/log.h"

namespace typodont::gpu {

namespace {

namespace fs = std::filesystem;

constexpr const char* kList = "left-as";          // name of the file that lists all cached files with their hashes
constexpr const char* kPipelines = "pipelines-";  // prefix of a pipeline cache's file name
// bytes; a smaller cache is only a header or checksum and is not stored
constexpr std::size_t kEmptyCacheBytes = 64;
fs::path g_folder;   // the cache folder; set before other threads start
std::mutex g_mutex;  // protects the cache folder
bool g_checked = false;
std::set<fs::path> g_good;  // files whose hash was checked and is correct

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::uint64_t hash_of(const std::string& text) {
  Sha256 hash;
  hash.bytes(text.data(), text.size());
  return hash.key();
}

/// Returns the hash of each file by its relative path, without the list itself.
std::map<std::string, std::uint64_t> files_now() {
  std::map<std::string, std::uint64_t> files;
  std::error_code code;
  for (fs::recursive_directory_iterator it(g_folder, code), end; !code && it != end; it.increment(code)) {
    const std::string name = it->path().lexically_relative(g_folder).string();
    if (!it->is_regular_file(code) || name == kList || name.find('\n') != std::string::npos) continue;
    if (const auto hash = cache::hash_of(it->path())) files[name] = *hash;
  }
  return files;
}

fs::path pipelines_file(const VkPhysicalDeviceProperties& properties) {
  std::string name = kPipelines;
  for (const std::uint8_t byte : properties.pipelineCacheUUID) name += fmt::format("{:02x}", byte);
  return g_folder / name;
}

}  // namespace

void keep_driver_cache(const fs::path& folder) {
  g_folder = folder;
  if (!folder.empty()) ::setenv("MESA_SHADER_CACHE_DIR", folder.c_str(), 0);
}

void check_driver_cache() {
  const std::lock_guard lock(g_mutex);
  if (g_folder.empty() || std::exchange(g_checked, true)) return;
  std::error_code code;
  const std::string list = bytes_of(g_folder / kList);
  // Start of the last line. For a single line, rfind() returns npos, and npos + 1 is 0.
  const std::size_t last = list.size() > 1 ? list.rfind('\n', list.size() - 2) + 1 : 0;
  if (list.substr(last) != fmt::format("{:016x}\n", hash_of(list.substr(0, last)))) {  // wrong or missing checksum
    if (!list.empty()) log::info("{} is damaged and is created again", g_folder.string());
    for (fs::directory_iterator it(g_folder, code), end; !code && it != end; it.increment(code)) {
      const std::string name = it->path().filename().string();
      std::error_code kept;
      if (name == kList || name.starts_with("mesa_") || name.starts_with(kPipelines)) fs::remove_all(it->path(), kept);
    }
    fs::create_directories(g_folder, code);  // Mesa creates only its own folder, not the folders above it
    return;
  }
  const auto now = files_now();
  std::istringstream lines(list.substr(0, last));
  for (std::string line; std::getline(lines, line);) {
    const std::string name = line.substr(std::min<std::size_t>(17, line.size()));  // line format: "HASH name"
    const auto found = now.find(name);
    if (found == now.end()) continue;
    if (line == fmt::format("{:016x} {}", found->second, name)) {
      g_good.insert(g_folder / name);
    } else {
      fs::remove(g_folder / name, code);
    }
  }
}

VkPipelineCache open_pipelines(VkDevice device, const VkPhysicalDeviceProperties& properties) {
  const std::lock_guard lock(g_mutex);
  if (g_folder.empty()) return VK_NULL_HANDLE;
  const fs::path file = pipelines_file(properties);
  const std::string bytes = g_good.contains(file) ? bytes_of(file) : "";
  const VkPipelineCacheCreateInfo info{.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO,
                                       .initialDataSize = bytes.size(),
                                       .pInitialData = bytes.data()};
  VkPipelineCache pipelines = VK_NULL_HANDLE;
  return vkCreatePipelineCache(device, &info, nullptr, &pipelines) == VK_SUCCESS ? pipelines : VK_NULL_HANDLE;
}

void close_pipelines(VkDevice device, const VkPhysicalDeviceProperties& properties, VkPipelineCache pipelines) {
  if (!pipelines) return;
  std::size_t size = 0;
  std::string bytes;
  if (vkGetPipelineCacheData(device, pipelines, &size, nullptr) == VK_SUCCESS && size > kEmptyCacheBytes) {
    bytes.resize(size);
    if (vkGetPipelineCacheData(device, pipelines, &size, bytes.data()) != VK_SUCCESS) size = 0;
    bytes.resize(size);
  }
  vkDestroyPipelineCache(device, pipelines, nullptr);
  const std::lock_guard lock(g_mutex);
  const fs::path file = pipelines_file(properties);
  if (bytes.empty() || bytes == bytes_of(file)) return;
  try {
    std::error_code code;
    fs::create_directories(g_folder, code);
    write_file_atomically(file, bytes, FileKind::kCache);
  } catch (const Error&) {  // caching is optional: nothing is stored
  }
}

void list_driver_cache() {
  const std::lock_guard lock(g_mutex);
  if (g_folder.empty()) return;
  std::string list;
  for (const auto& [name, hash] : files_now()) list += fmt::format("{:016x} {}\n", hash, name);
  if (list.empty()) return;
  list += fmt::format("{:016x}\n", hash_of(list));
  if (list == bytes_of(g_folder / kList)) return;
  try {
    write_file_atomically(g_folder / kList, list, FileKind::kCache);
  } catch (const Error&) {  // caching is optional: nothing is stored
  }
}

}  // namespace typodont::gpu
