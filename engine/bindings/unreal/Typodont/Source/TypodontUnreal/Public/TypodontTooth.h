// An actor for Unreal Engine 5: hard tissue that can be felt and drilled. Place the actor in a level. It uses only the
// C interface (typodont.h). The servo runs at 1 kHz on its own thread, and the tissue is updated on a second thread.
// Each brick (block) of the tissue's surface is a procedural mesh. A video frame replaces only the changed meshes.
//
// In the actor's frame one unit is one centimetre, as everywhere in Unreal. So a tooth is about one unit wide; scale
// the actor to enlarge it. The library's frame W is right-handed, Unreal is left-handed: the actor's y axis is -y of W.
#pragma once

#include "CoreMinimal.h"
#include "GameFramework/Actor.h"
#include "TypodontTooth.generated.h"

class FTypodontBench;
class UMaterialInterface;
class UProceduralMeshComponent;

UCLASS()
class TYPODONTUNREAL_API ATypodontTooth : public AActor {
  GENERATED_BODY()

 public:
  ATypodontTooth();

  /** A shipped scene, a scene file, or a scene as JSON text. */
  UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "Typodont")
  FString Scene = TEXT("molar-caries");

  /** The hand moves this actor. Its origin is the centre of the tool's head, and its z axis points along the shank. */
  UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "Typodont")
  TObjectPtr<AActor> Hand;

  /** This actor is shown as the tool: it follows the hand, but stays outside the tissue. */
  UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "Typodont")
  TObjectPtr<AActor> ShownTool;

  UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "Typodont")
  TObjectPtr<UMaterialInterface> Material;

  /** 0..1 */
  UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "Typodont")
  float Pedal = 0;

  /** Force of the newest tick on the hand, N, in the actor's axes. */
  UPROPERTY(BlueprintReadOnly, Category = "Typodont")
  FVector Force = FVector::ZeroVector;

  /** Volume removed since the start, mm3. */
  UPROPERTY(BlueprintReadOnly, Category = "Typodont")
  double Removed = 0;

  /** Why there is no tissue; empty if there is. */
  UPROPERTY(BlueprintReadOnly, Category = "Typodont")
  FString Error;

  /** Reverts the last stroke. False if there is none. */
  UFUNCTION(BlueprintCallable, Category = "Typodont")
  bool Undo();

  virtual void BeginPlay() override;
  virtual void EndPlay(const EEndPlayReason::Type Reason) override;
  virtual void Tick(float DeltaSeconds) override;

 private:
  void SendHand();
  void ShowChangedBricks();

  UPROPERTY(Transient)
  TMap<FIntVector, TObjectPtr<UProceduralMeshComponent>> Bricks;

  TSharedPtr<FTypodontBench> Bench;
};
