#include <fcntl.h>
#include <fmt/format.h>
#include <pa_linux_alsa.h>
#include <portaudio.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cstdio>
#include <vector>

#include "audio/audio_output.h"
#include "audio/output/stream_backend.h"
#include "engine/base/error.h"
#include "engine/base/late_library.h"

namespace typodont::audio {

namespace {

constinit LateLibrary portaudio{TYPODONT_LATE_PORTAUDIO};
TYPODONT_LATE(portaudio, PaAlsa_EnableRealtimeScheduling, Pa_AbortStream, Pa_CloseStream, Pa_GetDefaultOutputDevice,
              Pa_GetDeviceCount, Pa_GetDeviceInfo, Pa_GetErrorText, Pa_GetHostApiInfo, Pa_GetStreamInfo, Pa_Initialize,
              Pa_IsStreamActive, Pa_OpenStream, Pa_StartStream, Pa_Terminate)

/// While an object of this class exists, messages of ALSA and JACK about missing devices are suppressed.
class QuietErrors {
 public:
  QuietErrors() {
    std::fflush(stderr);
    saved_ = dup(STDERR_FILENO);
    const int null = ::open("/dev/null", O_WRONLY);
    if (saved_ >= 0 && null >= 0) dup2(null, STDERR_FILENO);
    if (null >= 0) ::close(null);
  }
  ~QuietErrors() {
    if (saved_ < 0) return;
    dup2(saved_, STDERR_FILENO);
    ::close(saved_);
  }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

 private:
  int saved_ = -1;
};

/// PortAudio is initialised while an object of this class exists. The first object makes a new list of devices.
class Library {
 public:
  Library() {
    const QuietErrors quiet;
    const PaError error = Pa_Initialize();
    if (error != paNoError) throw RunFailure(fmt::format("PortAudio: {}", Pa_GetErrorText(error)));
  }
  ~Library() { Pa_Terminate(); }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
};

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

PaDeviceIndex find_output(const std::string& name) {
  if (name.empty()) {
    const PaDeviceIndex device = Pa_GetDefaultOutputDevice();
    if (device == paNoDevice) {
      throw RunFailure(
          "PortAudio: this machine has no sound output; \"--audio none:\" or \"--audio wav:FILE\" need none");
    }
    return device;
  }
  std::vector<std::string> names;
  PaDeviceIndex part = paNoDevice;
  for (PaDeviceIndex i = 0; i < Pa_GetDeviceCount(); ++i) {
    const PaDeviceInfo* info = Pa_GetDeviceInfo(i);
    if (info->maxOutputChannels < 1) continue;
    if (name == info->name) return i;
    names.emplace_back(info->name);
    if (part == paNoDevice && lower(info->name).find(lower(name)) != std::string::npos) part = i;
  }
  if (part != paNoDevice) return part;
  throw Error(
      "--audio", "", "\"portaudio:" + name + "\"",
      names.empty() ? "no name: this machine has no sound output" : fmt::format("one of: {}", fmt::join(names, "; ")));
}

class PortAudioBackend final : public StreamBackend {
 public:
  ~PortAudioBackend() override { close(); }

  StreamOpened open(const StreamRequest& request) override {
    close();
    muted_ = false;
    library_ = std::make_unique<Library>();
    request_ = request;
    const PaDeviceIndex device = find_output(request.device);
    const PaDeviceInfo& info = *Pa_GetDeviceInfo(device);
    PaStreamParameters parameters{};
    parameters.device = device;
    parameters.sampleFormat = paFloat32;
    double rate = request.sample_rate > 0 ? request.sample_rate : info.defaultSampleRate;
    parameters.suggestedLatency = request.buffer / rate;

    // Tries the requested format, then the device's own.
    const QuietErrors quiet;
    PaError error = paInvalidSampleRate;
    for (const double tried : {rate, info.defaultSampleRate}) {
      for (const int channels : {request.channels, 3 - request.channels}) {
        if (channels > info.maxOutputChannels || error == paNoError) continue;
        parameters.channelCount = channels_ = channels;
        rate = tried;
        error = Pa_OpenStream(&stream_, nullptr, &parameters, rate, static_cast<unsigned long>(request.buffer),
                              paClipOff | paDitherOff, &PortAudioBackend::callback, this);
      }
    }
    if (error != paNoError) {
      stream_ = nullptr;
      throw RunFailure(fmt::format("PortAudio: {}: {}", info.name, Pa_GetErrorText(error)));
    }
    if (Pa_GetHostApiInfo(info.hostApi)->type == paALSA) PaAlsa_EnableRealtimeScheduling(stream_, 1);
    const PaStreamInfo& got = *Pa_GetStreamInfo(stream_);
    return {info.name, got.sampleRate > 0 ? got.sampleRate : rate, got.outputLatency};
  }

  void start() override {
    const QuietErrors quiet;
    const PaError error = Pa_StartStream(stream_);
    if (error != paNoError) throw RunFailure(fmt::format("PortAudio: {}", Pa_GetErrorText(error)));
  }

  bool alive() noexcept override { return stream_ != nullptr && Pa_IsStreamActive(stream_) == 1; }

  void close() noexcept override {
    muted_ = true;
    if (stream_ != nullptr) {
      Pa_AbortStream(stream_);
      Pa_CloseStream(stream_);
      stream_ = nullptr;
    }
    library_.reset();
  }

 private:
  static int callback(const void*, void* out, unsigned long frames, const PaStreamCallbackTimeInfo*,
                      PaStreamCallbackFlags flags, void* self) {
    const auto* backend = static_cast<const PortAudioBackend*>(self);
    const StreamRequest& request = backend->request_;
    if (backend->muted_) {
      std::fill_n(static_cast<float*>(out), frames * static_cast<unsigned long>(backend->channels_), 0.0f);
      return paAbort;
    }
    const bool underrun = (flags & (paOutputUnderflow | paOutputOverflow)) != 0;
    // Uses now(), the clock of the ticks, because the clock of PortAudio may differ.
    const bool more = request.callback(request.self, static_cast<float*>(out), static_cast<int>(frames),
                                       backend->channels_, now(), underrun);
    return more ? paContinue : paComplete;
  }

  std::unique_ptr<Library> library_;
  StreamRequest request_;
  PaStream* stream_ = nullptr;
  int channels_ = 1;
  std::atomic<bool> muted_{true};
};

}  // namespace

std::unique_ptr<StreamBackend> make_portaudio_backend() {
  return std::make_unique<PortAudioBackend>();
}

std::vector<AudioDevice> audio_devices() {
  const Library library;
  std::vector<AudioDevice> devices;
  for (PaDeviceIndex i = 0; i < Pa_GetDeviceCount(); ++i) {
    const PaDeviceInfo& info = *Pa_GetDeviceInfo(i);
    if (info.maxOutputChannels < 1) continue;
    devices.push_back({info.name, Pa_GetHostApiInfo(info.hostApi)->name, info.defaultSampleRate, info.maxOutputChannels,
                       info.defaultLowOutputLatency, i == Pa_GetDefaultOutputDevice()});
  }
  return devices;
}

}  // namespace typodont::audio
