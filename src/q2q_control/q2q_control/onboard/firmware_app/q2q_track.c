/* Past motion of every vehicle, and the packets that bring it. */
#include <math.h>

#include "q2q_track.h"

static const float CLEARLY = 0.8f; /* of the farthest neighbour's distance: what a nearer one must be below [-] */

float q2q_seconds(uint32_t from_us, uint32_t to_us) { return (float)(int32_t)(to_us - from_us) * 1e-6f; }

bool q2q_finite(const struct q2q_motion *motion) {
  float sum = 0.0f;
  for (int k = 0; k < 3; ++k) sum += motion->pos[k] + motion->vel[k] + motion->axis[k];
  return isfinite(sum);
}

bool q2q_remember(struct q2q_track *track, uint32_t stamp_us, const struct q2q_motion *motion) {
  if (!q2q_finite(motion)) return false;
  if (track->count > 0 && (int32_t)(stamp_us - track->stamp_us[track->newest]) <= 0) return false;
  track->newest = (uint16_t)((track->newest + 1) % Q2Q_SAMPLES);
  track->stamp_us[track->newest] = stamp_us;
  track->sample[track->newest] = *motion;
  if (track->count < Q2Q_SAMPLES) ++track->count;
  return true;
}

bool q2q_heard(const struct q2q_track *track, uint32_t now_us) {
  const float age = q2q_seconds(track->stamp_us[track->newest], now_us);
  return track->count > 0 && age >= 0.0f && age <= Q2Q_STALE_S;
}

void q2q_forget(struct q2q_app *app, uint32_t now_us) {
  for (int k = 0; k < Q2Q_VEHICLES; ++k)
    if (!q2q_heard(&app->track[k], now_us)) app->track[k].count = 0;
}

/* Return whether the last sample and a stamp are at most Q2Q_STALE_S apart: packets may overtake each other. */
static bool near(const struct q2q_track *track, uint32_t stamp_us) {
  return track->count > 0 && fabsf(q2q_seconds(track->stamp_us[track->newest], stamp_us)) <= Q2Q_STALE_S;
}

/* Return how far a vehicle is from where its air would push this one: squares of the horizontal distance in widths
   of the jet and of the height in reaches, plus 1 for one level with it or below, whose air does not come up. */
static float distance(const struct q2q_motion *own, const struct q2q_motion *other) {
  const float x = other->pos[0] - own->pos[0], y = other->pos[1] - own->pos[1], z = other->pos[2] - own->pos[2];
  const float width = Q2Q_WIDTH + Q2Q_SPREAD * fabsf(z), aside = (x * x + y * y) / (2.0f * width * width);
  return aside + z * z / (Q2Q_REACH_VERTICAL * Q2Q_REACH_VERTICAL) + (z < Q2Q_BLEND ? 1.0f : 0.0f);
}

/* Return the place of the farthest neighbour, which a nearer one takes; 0 if it is not clearly nearer, so that two
   that are about as far do not alternate, or if the own position is unknown. */
static int farthest(const struct q2q_app *app, const struct q2q_motion *nearer) {
  const struct q2q_track *own = &app->track[0];
  const struct q2q_motion *here = &own->sample[own->newest];
  if (own->count == 0) return 0;
  int place = 0;
  float most = distance(here, nearer) / CLEARLY;
  for (int k = 1; k < Q2Q_VEHICLES; ++k) {
    const float far = distance(here, &app->track[k].sample[app->track[k].newest]);
    if (far <= most) continue;
    most = far;
    place = k;
  }
  return place;
}

/* Return the place of a neighbour, a free one, or that of one which is farther; 0 if there is none. */
static int place_for(const struct q2q_app *app, uint8_t id, uint32_t stamp_us, const struct q2q_motion *motion) {
  int place = 0;
  for (int k = 1; k < Q2Q_VEHICLES; ++k) {
    const bool heard = near(&app->track[k], stamp_us);
    if (heard && app->track[k].id == id) return k;
    if (!heard && place == 0) place = k;
  }
  return place != 0 ? place : farthest(app, motion);
}

bool q2q_hear(struct q2q_app *app, uint8_t id, uint32_t stamp_us, const struct q2q_motion *motion) {
  if (!q2q_finite(motion)) return false;
  const int place = place_for(app, id, stamp_us, motion);
  struct q2q_track *track = &app->track[place];
  if (place == 0) {
    if (app->track[0].count > 0) ++app->unheard;
    return false;
  }
  if (track->id != id || !near(track, stamp_us)) { /* another's, or silent for too long to be interpolated */
    track->id = id;
    track->count = 0;
    app->strength[place] = 1.0f;
    app->direct[place] = 0.0f;
  }
  return q2q_remember(track, stamp_us, motion);
}

/* Interpolate between two samples; share 0 is the first. Velocity and axis are needed by some models only. */
static void between(const struct q2q_motion *a, const struct q2q_motion *b, float share, struct q2q_motion *out) {
  *out = *a;
  for (int k = 0; k < 3; ++k) out->pos[k] += share * (b->pos[k] - a->pos[k]);
  if (Q2Q_CARRIED <= 0.0f && Q2Q_LOADING <= 0.0f) return;
  for (int k = 0; k < 3; ++k) {
    out->vel[k] += share * (b->vel[k] - a->vel[k]);
    out->axis[k] += share * (b->axis[k] - a->axis[k]);
  }
}

void q2q_motion_after(const struct q2q_motion *motion, float seconds, struct q2q_motion *out) {
  *out = *motion;
  for (int k = 0; k < 3; ++k) out->pos[k] += seconds * motion->vel[k];
}

/* Return the place of the k-th sample before the newest one. */
static int place_of(const struct q2q_track *track, int k) {
  const int place = track->newest - k;
  return place < 0 ? place + Q2Q_SAMPLES : place;
}

static float age_of(const struct q2q_track *track, uint32_t now_us, int k) {
  return q2q_seconds(track->stamp_us[place_of(track, k)], now_us);
}

float q2q_oldest(const struct q2q_track *track, uint32_t now_us) { return age_of(track, now_us, track->count - 1); }

void q2q_motion_at(const struct q2q_track *track, uint32_t now_us, float age, struct q2q_motion *out) {
  int after = 0, before = track->count - 1;
  float age_after = age_of(track, now_us, after), age_before = age_of(track, now_us, before);
  if (age <= age_after) {
    q2q_motion_after(&track->sample[track->newest], age_after - age, out);
  } else if (age >= age_before) {
    *out = track->sample[place_of(track, before)];
  } else {
    while (before - after > 1) { /* bisection */
      const int middle = (after + before) / 2;
      const float age_middle = age_of(track, now_us, middle);
      if (age < age_middle) {
        before = middle;
        age_before = age_middle;
      } else {
        after = middle;
        age_after = age_middle;
      }
    }
    const float share = (age_before - age) / (age_before - age_after);
    between(&track->sample[place_of(track, before)], &track->sample[place_of(track, after)], share, out);
  }
}

/* Return whether a value is within the range of a packet. */
static bool fits(float value, float unit) { return fabsf(value) <= 32767.0f * unit; }

static void put(uint8_t *bytes, float value, float unit) {
  const int16_t whole = (int16_t)roundf(value / unit);
  bytes[0] = (uint8_t)((uint16_t)whole & 0xffu);
  bytes[1] = (uint8_t)((uint16_t)whole >> 8);
}

static float get(const uint8_t *bytes, float unit) {
  return unit * (float)(int16_t)(uint16_t)((uint16_t)bytes[0] | (uint16_t)(bytes[1] << 8));
}

bool q2q_pack(uint8_t id, const struct q2q_motion *motion, uint8_t packet[Q2Q_PACKET_BYTES]) {
  if (!q2q_finite(motion)) return false;
  for (int k = 0; k < 3; ++k)
    if (!fits(motion->pos[k], 1e-3f) || !fits(motion->vel[k], 1e-3f) || !fits(motion->axis[k], 1e-4f)) return false;
  packet[0] = id;
  for (int k = 0; k < 3; ++k) {
    put(packet + 1 + 2 * k, motion->pos[k], 1e-3f);
    put(packet + 7 + 2 * k, motion->vel[k], 1e-3f);
  }
  put(packet + 13, motion->axis[0], 1e-4f);
  put(packet + 15, motion->axis[1], 1e-4f);
  return true;
}

uint8_t q2q_unpack(const uint8_t packet[Q2Q_PACKET_BYTES], struct q2q_motion *motion) {
  for (int k = 0; k < 3; ++k) {
    motion->pos[k] = get(packet + 1 + 2 * k, 1e-3f);
    motion->vel[k] = get(packet + 7 + 2 * k, 1e-3f);
  }
  const float x = get(packet + 13, 1e-4f), y = get(packet + 15, 1e-4f);
  const float squared = 1.0f - x * x - y * y;
  motion->axis[0] = x;
  motion->axis[1] = y;
  motion->axis[2] = squared > 0.0f ? sqrtf(squared) : 0.0f;
  return packet[0];
}
