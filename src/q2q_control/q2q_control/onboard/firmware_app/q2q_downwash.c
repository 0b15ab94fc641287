/* Downwash of all neighbours at this vehicle: pairs, their transport delay, and the strength of each source.

     eta_i = sum_j s_ij f(r_j(t - tau) - r_i(t), v_j(t - tau), b_j(t - tau), v_i(t))

   f is the jet of q2q_model.downwash.jet, s the strength of q2q_model.downwash.source_strength. s needs the pairs
   between the others too, so it is kept, and renewed for one source at a time; it is 1 without loading and
   absorption. */
#include <math.h>

#include "q2q_track.h"

#define FADED 30.0f /* exponents beyond it give less than 1e-13 of a jet */
static const float APART = 9.0f * Q2Q_BLEND; /* height difference beyond which roles do not blend [m] */

/* All vehicles at the instant of the prediction. */
struct scene {
  const struct q2q_app *app;
  uint32_t now_us;
  float lead_s;
  bool here[Q2Q_VEHICLES];
  struct q2q_motion now[Q2Q_VEHICLES];
};

static float smaller(float a, float b) { return a < b ? a : b; }
static float larger(float a, float b) { return a > b ? a : b; }

/* Return tanh(dz / blend). */
static float side(float dz) {
  return dz > APART ? 1.0f : dz < -APART ? -1.0f : 1.0f - 2.0f / (expf(2.0f * dz / Q2Q_BLEND) + 1.0f);
}

static float delay(float dz) {
  return Q2Q_TRAVEL_SPEED > 0.0f ? smaller(larger(dz, 0.0f), Q2Q_RANGE) / Q2Q_TRAVEL_SPEED : 0.0f;
}

/* Write the horizontal way of the air since it left its source [m]. */
static void drift(float dz, const struct q2q_motion *source, float way[2]) {
  const float upright = larger(source->axis[2], 0.5f);
  const float sx = source->axis[0] / upright, sy = source->axis[1] / upright;
  const float fall = larger(dz, 0.0f), cut = larger(sqrtf(sx * sx + sy * sy) / Q2Q_STEEPEST, 1.0f);
  const float tau = Q2Q_VELOCITY_SHARE * delay(fall);
  way[0] = Q2Q_CARRIED * (source->vel[0] * tau - fall * sx / cut);
  way[1] = Q2Q_CARRIED * (source->vel[1] * tau - fall * sy / cut);
}

/* Return the vertical acceleration of vehicle `at` by a source when its air left it [m/s^2]. */
static float jet(const struct q2q_motion *source, const struct q2q_motion *at) {
  float x = source->pos[0] - at->pos[0], y = source->pos[1] - at->pos[1], meeting = 1.0f;
  const float dz = source->pos[2] - at->pos[2], sign = side(dz), gap = dz * sign;
  if (Q2Q_CARRIED > 0.0f) {
    float way[2];
    drift(dz, source, way);
    x += way[0];
    y += way[1];
    if (Q2Q_TRAVEL_SPEED > 0.0f) meeting = larger(1.0f + Q2Q_CARRIED * at->vel[2] / Q2Q_TRAVEL_SPEED, 0.0f);
  }
  const float width = Q2Q_WIDTH + Q2Q_SPREAD * gap, aside = (x * x + y * y) / (2.0f * width * width);
  if (aside > FADED) return 0.0f;
  float decay = 1.0f, exponent = -aside;
  if (Q2Q_POWER) {
    decay = (Q2Q_VIRTUAL_ORIGIN + Q2Q_REFERENCE_GAP) / (Q2Q_VIRTUAL_ORIGIN + gap);
    decay *= decay;
  } else {
    exponent -= Q2Q_DECAY_RATE * (gap - Q2Q_REFERENCE_GAP);
  }
  const float below = 0.5f * (1.0f + sign);
  return (Q2Q_UPPER_RATIO * (1.0f - below) - below) * Q2Q_STRENGTH * decay * expf(exponent) * meeting;
}

/* Place all vehicles where they are `lead_s` after now_us. */
static void place(struct scene *scene, const struct q2q_app *app, const struct q2q_motion *own, uint32_t now_us,
                  float lead_s) {
  scene->app = app;
  scene->now_us = now_us;
  scene->lead_s = lead_s;
  for (int k = 0; k < Q2Q_VEHICLES; ++k) {
    const struct q2q_track *track = &app->track[k];
    scene->here[k] = k == 0 || q2q_heard(track, now_us);
    if (!scene->here[k]) continue;
    struct q2q_motion *now = &scene->now[k];
    if (k == 0)
      q2q_motion_after(own, lead_s, now);
    else
      q2q_motion_at(track, now_us, -lead_s, now);
  }
}

/* Return whether source j may push vehicle i. Between two others only downward pushes count: a source far
   enough below gives none. */
static bool may_push(const struct scene *scene, int i, int j) {
  if (i == j || !scene->here[i] || !scene->here[j]) return false;
  return i == 0 || Q2Q_UPPER_RATIO < 0.0f || scene->now[j].pos[2] - scene->now[i].pos[2] >= -APART;
}

/* Return whether the source is farther aside than the reach. */
static bool aside(const struct q2q_motion *source, const struct q2q_motion *at) {
  const float x = source->pos[0] - at->pos[0], y = source->pos[1] - at->pos[1];
  return x * x + y * y > Q2Q_REACH_HORIZONTAL * Q2Q_REACH_HORIZONTAL;
}

/* Return the downwash of source j alone at vehicle i [m/s^2]: none beyond the reach, by the rule of
   q2q_model.geometry.pair_reach. */
static float pair(const struct scene *scene, int i, int j) {
  const struct q2q_track *track = &scene->app->track[j];
  const struct q2q_motion *at = &scene->now[i], *now = &scene->now[j];
  const float tau = delay(now->pos[2] - at->pos[2]);
  struct q2q_motion then = *now;
  if (Q2Q_MAX_DELAY > 0.0f && track->count > 0) q2q_motion_at(track, scene->now_us, tau - scene->lead_s, &then);
  if (fabsf(then.pos[2] - at->pos[2]) > Q2Q_REACH_VERTICAL || (aside(&then, at) && aside(now, at))) return 0.0f;
  return jet(&then, at);
}

static float down(float push) { return push < 0.0f ? -push : 0.0f; }

/* Return thrust over weight of source j when its air left it, without the downwash on j; 1 where unknown. */
static float thrust_ratio(const struct scene *scene, int j) {
  const struct q2q_track *track = &scene->app->track[j];
  if (Q2Q_LOADING <= 0.0f || track->count == 0) return 1.0f;
  const float age = delay(scene->now[j].pos[2] - scene->now[0].pos[2]) - scene->lead_s;
  const float newest = q2q_seconds(track->stamp_us[track->newest], scene->now_us);
  const float oldest = q2q_oldest(track, scene->now_us);
  const float after = larger(age - Q2Q_HALF_SPAN_S, 0.0f), before = age + Q2Q_HALF_SPAN_S;
  const float seen = smaller(before, oldest) - larger(after, newest);
  if (!(seen > 0.5f * Q2Q_HALF_SPAN_S)) return 1.0f;
  struct q2q_motion from, to;
  q2q_motion_at(track, scene->now_us, before, &from);
  q2q_motion_at(track, scene->now_us, after, &to);
  const float x = (to.vel[0] - from.vel[0]) / seen, y = (to.vel[1] - from.vel[1]) / seen;
  const float z = (to.vel[2] - from.vel[2]) / seen + Q2Q_GRAVITY;
  return sqrtf(x * x + y * y + z * z) / Q2Q_GRAVITY;
}

/* Return the share of `direct` that a vehicle takes which feels `taken` and gives `middle`. */
static float absorbed(float direct, float middle, float taken) {
  if (direct >= 0.0f || middle >= 0.0f || taken >= 0.0f) return 0.0f;
  return smaller(-Q2Q_ABSORPTION * taken / Q2Q_GRAVITY, 1.0f) * smaller(middle / direct, 1.0f);
}

float q2q_downwash(struct q2q_app *app, const struct q2q_motion *own, uint32_t now_us, float lead_s) {
  struct scene scene;
  float eta = 0.0f;
  place(&scene, app, own, now_us, lead_s);
  for (int j = 1; j < Q2Q_VEHICLES; ++j) {
    app->direct[j] = may_push(&scene, 0, j) ? pair(&scene, 0, j) : 0.0f;
    eta += app->strength[j] * app->direct[j];
  }
  return eta;
}

void q2q_renew_strength(struct q2q_app *app, const struct q2q_motion *own, uint32_t now_us, int j) {
  app->strength[j] = 1.0f;
  if (app->direct[j] == 0.0f) return;
  struct scene scene;
  place(&scene, app, own, now_us, 0.0f);
  float excess = thrust_ratio(&scene, j) - 1.0f, taken = 0.0f;
  for (int k = 0; k < Q2Q_VEHICLES; ++k) {
    if (may_push(&scene, j, k)) excess += down(pair(&scene, j, k)) / Q2Q_GRAVITY;
    if (k != 0 && app->direct[k] < 0.0f && may_push(&scene, k, j))
      taken += absorbed(app->direct[j], app->direct[k], pair(&scene, k, j));
  }
  app->strength[j] = larger(1.0f + Q2Q_LOADING * excess - taken, 0.0f);
}
