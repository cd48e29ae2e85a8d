// The declarations of Unreal Engine 5 that engine/bindings/unreal uses, with the smallest definitions that let a test
// run it without Unreal. Written from Unreal's public documentation; this is not Unreal's code. What only Unreal can
// check (reflection, garbage collection, drawing, its build tool) is not checked with it.
#pragma once

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

using int32 = std::int32_t;
using int64 = std::int64_t;
using uint8 = std::uint8_t;
using uint32 = std::uint32_t;
using TCHAR = char16_t;
#define TEXT(text) u##text
#define UCLASS(...)
#define UPROPERTY(...)
#define UFUNCTION(...)
#define GENERATED_BODY()
#define TYPODONTUNREAL_API
#define IMPLEMENT_MODULE(implementation, name)
#define DEFINE_LOG_CATEGORY_STATIC(name, shown, compiled) [[maybe_unused]] static const char* const name = #name
#define UE_LOG(category, verbosity, format, text) \
  std::fprintf(stderr, "%s " #verbosity ": %s\n", category, FTCHARToUTF8(text).Get())

// --- Values ---

struct FVector {
  double X = 0, Y = 0, Z = 0;
  FVector() = default;
  FVector(double x, double y, double z) : X(x), Y(y), Z(z) {}
  FVector operator+(const FVector& b) const { return {X + b.X, Y + b.Y, Z + b.Z}; }
  FVector operator-(const FVector& b) const { return {X - b.X, Y - b.Y, Z - b.Z}; }
  FVector operator*(double s) const { return {X * s, Y * s, Z * s}; }
  FVector operator/(double s) const { return {X / s, Y / s, Z / s}; }
  static double DotProduct(const FVector& a, const FVector& b) { return a.X * b.X + a.Y * b.Y + a.Z * b.Z; }
  static FVector CrossProduct(const FVector& a, const FVector& b) {
    return {a.Y * b.Z - a.Z * b.Y, a.Z * b.X - a.X * b.Z, a.X * b.Y - a.Y * b.X};
  }
  double Size() const { return std::sqrt(DotProduct(*this, *this)); }
  static const FVector ZeroVector;
};
inline const FVector FVector::ZeroVector;
struct FVector2D {
  double X = 0, Y = 0;
};
struct FIntVector {
  int32 X, Y, Z;
  FIntVector(int32 x, int32 y, int32 z) : X(x), Y(y), Z(z) {}
  bool operator<(const FIntVector& b) const { return std::tie(X, Y, Z) < std::tie(b.X, b.Y, b.Z); }
};
struct FMath {
  static double Exp(double x) { return std::exp(x); }
};
struct FQuat {
  double X = 0, Y = 0, Z = 0, W = 1;
  FQuat() = default;
  FQuat(double x, double y, double z, double w) : X(x), Y(y), Z(z), W(w) {}
  FQuat Inverse() const { return {-X, -Y, -Z, W}; }
  FQuat operator*(const FQuat& b) const {
    return {W * b.X + X * b.W + Y * b.Z - Z * b.Y, W * b.Y - X * b.Z + Y * b.W + Z * b.X,
            W * b.Z + X * b.Y - Y * b.X + Z * b.W, W * b.W - X * b.X - Y * b.Y - Z * b.Z};
  }
  static FQuat Slerp(const FQuat& a, const FQuat& b, double fraction) {
    const double cosine = a.X * b.X + a.Y * b.Y + a.Z * b.Z + a.W * b.W,
                 angle = std::acos(std::min(std::abs(cosine), 1.0));
    const double sine = std::sin(angle), wa = sine > 1e-9 ? std::sin((1 - fraction) * angle) / sine : 1 - fraction;
    const double wb = (cosine < 0 ? -1 : 1) * (sine > 1e-9 ? std::sin(fraction * angle) / sine : fraction);
    return {wa * a.X + wb * b.X, wa * a.Y + wb * b.Y, wa * a.Z + wb * b.Z, wa * a.W + wb * b.W};
  }
  FVector RotateVector(const FVector& v) const {
    const FQuat r = *this * FQuat(v.X, v.Y, v.Z, 0) * Inverse();
    return {r.X, r.Y, r.Z};
  }
};
class FTransform {
 public:
  FTransform() = default;
  FTransform(const FQuat& rotation, const FVector& location) : rotation_(rotation), location_(location) {}
  FTransform(const FQuat& rotation, const FVector& location, double scale)
      : rotation_(rotation), location_(location), scale_(scale) {}
  FVector GetLocation() const { return location_; }
  FQuat GetRotation() const { return rotation_; }
  FVector TransformPosition(const FVector& p) const { return rotation_.RotateVector(p * scale_) + location_; }
  FVector InverseTransformPosition(const FVector& p) const {
    return rotation_.Inverse().RotateVector(p - location_) / scale_;
  }
  FQuat TransformRotation(const FQuat& q) const { return rotation_ * q; }
  FQuat InverseTransformRotation(const FQuat& q) const { return rotation_.Inverse() * q; }

 private:
  FQuat rotation_;
  FVector location_;
  double scale_ = 1;
};
struct FColor {
  uint8 R, G, B;
  FColor(uint8 r, uint8 g, uint8 b) : R(r), G(g), B(b) {}
};
struct FProcMeshTangent {};

class FString {
 public:
  FString() = default;
  FString(const TCHAR* text) : text_(text) {}
  const TCHAR* operator*() const { return text_.c_str(); }
  bool IsEmpty() const { return text_.empty(); }

 private:
  std::u16string text_;
};
class FTCHARToUTF8 {  // of ASCII
 public:
  explicit FTCHARToUTF8(const TCHAR* text) {
    for (; *text; ++text) text_.push_back(static_cast<char>(*text));
  }
  const char* Get() const { return text_.c_str(); }

 private:
  std::string text_;
};
class FUTF8ToTCHAR {
 public:
  explicit FUTF8ToTCHAR(const char* text) {
    for (; *text; ++text) text_.push_back(static_cast<unsigned char>(*text));
  }
  const TCHAR* Get() const { return text_.c_str(); }

 private:
  std::u16string text_;
};
#define UTF8_TO_TCHAR(text) FUTF8ToTCHAR(text).Get()

// --- Containers and pointers ---

template <class T>
class TArray {
 public:
  void Reserve(int32 count) { items_.reserve(static_cast<std::size_t>(count)); }
  void Add(const T& item) { items_.push_back(item); }
  int32 Num() const { return static_cast<int32>(items_.size()); }
  const T& operator[](int32 i) const { return items_.at(static_cast<std::size_t>(i)); }

 private:
  std::vector<T> items_;
};
template <class K, class V>
class TMap {
 public:
  V& FindOrAdd(const K& key) { return items_[key]; }

 private:
  std::map<K, V> items_;
};
template <class T>
class TObjectPtr {
 public:
  TObjectPtr(T* object = nullptr) : object_(object) {}
  T* operator->() const { return object_; }
  T& operator*() const { return *object_; }
  operator T*() const { return object_; }

 private:
  T* object_;
};
template <class F>
using TFunction = std::function<F>;
template <class T>
class TSharedPtr {
 public:
  TSharedPtr() = default;
  TSharedPtr(std::shared_ptr<T> object) : object_(std::move(object)) {}
  T* operator->() const { return object_.get(); }
  explicit operator bool() const { return object_ != nullptr; }
  void Reset() { object_.reset(); }

 private:
  std::shared_ptr<T> object_;
};
template <class T>
TSharedPtr<T> MakeShared() {
  return std::make_shared<T>();
}
template <class T>
class TUniquePtr : public std::unique_ptr<T> {
 public:
  using std::unique_ptr<T>::unique_ptr;
  void Reset() { this->reset(); }
};
template <class T, class... Arguments>
TUniquePtr<T> MakeUnique(Arguments&&... arguments) {
  return TUniquePtr<T>(new T(std::forward<Arguments>(arguments)...));
}
template <class T>
std::remove_reference_t<T>&& MoveTemp(T&& object) {
  return static_cast<std::remove_reference_t<T>&&>(object);
}

// --- Threads ---

enum EThreadPriority { TPri_AboveNormal, TPri_TimeCritical };
class FRunnable {
 public:
  virtual ~FRunnable() = default;
  virtual uint32 Run() = 0;
  virtual void Stop() {}
};
class FRunnableThread {
 public:
  static FRunnableThread* Create(FRunnable* runnable, const TCHAR*, uint32, EThreadPriority) {
    return new FRunnableThread(runnable);
  }
  ~FRunnableThread() {
    if (thread_.joinable()) thread_.join();
  }
  bool Kill(bool) {
    runnable_->Stop();
    thread_.join();
    return true;
  }

 private:
  explicit FRunnableThread(FRunnable* runnable) : runnable_(runnable), thread_([runnable] { runnable->Run(); }) {}
  FRunnable* runnable_;
  std::thread thread_;
};
using FCriticalSection = std::mutex;
class FScopeLock {
 public:
  explicit FScopeLock(FCriticalSection* lock) : lock_(*lock) {}

 private:
  std::lock_guard<std::mutex> lock_;
};
template <class T>
class TTripleBuffer {
 public:
  void WriteAndSwap(const T value) {
    slots_[write_] = value;
    write_ = middle_.exchange(write_ | kDirty) & ~kDirty;
  }
  const T& SwapAndRead() {
    if (middle_ & kDirty) read_ = middle_.exchange(read_) & ~kDirty;
    return slots_[read_];
  }

 private:
  static constexpr int kDirty = 4;
  T slots_[3] = {};
  int write_ = 0, read_ = 1;
  std::atomic<int> middle_{2};
};
struct FPlatformTime {
  static double Seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }
};
struct FPlatformProcess {
  static void SleepNoStats(float seconds) { std::this_thread::sleep_for(std::chrono::duration<float>(seconds)); }
};

// --- Objects ---

class UObject {
 public:
  virtual ~UObject() = default;
};
/// All objects live until the end of the program.
inline std::vector<std::unique_ptr<UObject>>& all_objects() {
  static std::vector<std::unique_ptr<UObject>> objects;
  return objects;
}
template <class T>
T* NewObject(UObject* = nullptr) {
  all_objects().push_back(std::make_unique<T>());
  return static_cast<T*>(all_objects().back().get());
}
class UMaterialInterface : public UObject {};
class USceneComponent : public UObject {
 public:
  void SetupAttachment(USceneComponent* parent) { parent_ = parent; }
  void RegisterComponent() { registered_ = true; }
  bool shown() const { return registered_ && parent_; }

 private:
  USceneComponent* parent_ = nullptr;
  bool registered_ = false;
};
class UProceduralMeshComponent : public USceneComponent {
 public:
  void SetMaterial(int32, UMaterialInterface*) {}
  void ClearMeshSection(int32) { positions = {}, normals = {}, triangles = {}, ++changes; }
  void CreateMeshSection(int32, const TArray<FVector>& p, const TArray<int32>& t, const TArray<FVector>& n,
                         const TArray<FVector2D>&, const TArray<FColor>& c, const TArray<FProcMeshTangent>&, bool) {
    positions = p, triangles = t, normals = n, colours = c, ++changes;
  }
  TArray<FVector> positions, normals;
  TArray<FColor> colours;
  TArray<int32> triangles;
  int changes = 0;
};
struct EEndPlayReason {
  enum Type { Quit };
};
class AActor : public UObject {
 public:
  using Super = AActor;
  virtual void BeginPlay() {}
  virtual void EndPlay(const EEndPlayReason::Type) {}
  virtual void Tick(float) {}
  FTransform GetActorTransform() const { return X_; }
  FVector GetActorLocation() const { return X_.GetLocation(); }
  FQuat GetActorQuat() const { return X_.GetRotation(); }
  bool SetActorLocationAndRotation(const FVector& location, const FQuat& rotation) {
    X_ = FTransform(rotation, location);
    return true;
  }
  void SetActorTransform(const FTransform& X) { X_ = X; }

 protected:
  template <class T>
  T* CreateDefaultSubobject(const TCHAR*) {
    return NewObject<T>(this);
  }
  struct {
    bool bCanEverTick = false;
  } PrimaryActorTick;
  TObjectPtr<USceneComponent> RootComponent;

 private:
  FTransform X_;
};
