// SPDX-License-Identifier: MIT
#pragma once

namespace dynfilter::render {

class SceneBuilder;

}  // namespace dynfilter::render

namespace dynfilter::render::script {

/// The own car drives through a street at 8 to 14 m/s. Nothing moves, cars are parked on both sides.
void street(SceneBuilder& b);

/// The same with oncoming cars, two cars ahead and two pedestrians.
void street_traffic(SceneBuilder& b);

/// One car ahead at a constant distance: its image does not move.
void street_follow(SceneBuilder& b);

/// Oncoming cars only. They move along the epipolar lines.
void street_oncoming(SceneBuilder& b);

/// The own car waits at a crossing. Cars, vans and buses cross in front of it from both sides.
void junction(SceneBuilder& b);

/// The own car turns right at a crossing, among traffic.
void street_turn(SceneBuilder& b);

/// A camera flies fast through a hall where nothing moves.
void hall(SceneBuilder& b);

/// The same with people who walk.
void hall_people(SceneBuilder& b);

}  // namespace dynfilter::render::script
