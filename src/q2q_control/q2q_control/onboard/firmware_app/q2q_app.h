/* Downwash of the nearest Q2Q_NEIGHBOURS vehicles at this one, corrected by its accelerometer.

   C99, single precision, no heap: all state is in struct q2q_app, all parameters are in q2q_model.h. Frames as
   everywhere in q2q: world, z up, SI units. Times are microseconds of this vehicle's clock; they may wrap. */
#ifndef Q2Q_APP_H
#define Q2Q_APP_H

#include <stdbool.h>
#include <stdint.h>

#include "q2q_model.h"

enum {
  Q2Q_VEHICLES = 1 + Q2Q_NEIGHBOURS, /* this vehicle is number 0 */
  Q2Q_PACKET_BYTES = 17
};

struct q2q_motion {
  float pos[3];  /* [m] */
  float vel[3];  /* [m/s] */
  float axis[3]; /* body z, unit length */
};

/* Motion of one vehicle over the last Q2Q_SAMPLES broadcasts, a ring. */
struct q2q_track {
  uint32_t stamp_us[Q2Q_SAMPLES];
  struct q2q_motion sample[Q2Q_SAMPLES];
  uint16_t count, newest;
  uint8_t id;
};

/* Residual of the model at this vehicle: symbols of q2q_model.downwash.correction.corrected_predictor. */
struct q2q_correction {
  float residual; /* r^ [m/s^2] */
  float variance; /* P [m^2/s^4] */
  float offset;   /* b [m/s^2] */
  float clear_s;  /* time in clear air [s] */
  bool seen;      /* something has been measured */
};

struct q2q_app {
  struct q2q_track track[Q2Q_VEHICLES];
  struct q2q_correction correction;
  float strength[Q2Q_VEHICLES]; /* s of each source */
  float direct[Q2Q_VEHICLES];   /* downwash of each source alone, as last predicted [m/s^2] */
  float eta;                    /* prediction for the present [m/s^2] */
  float ahead;                  /* prediction for the time when the rotors will have answered [m/s^2] */
  float thrust;                 /* of the rotors over the mass, after their lag [m/s^2] */
  uint32_t last_us; /* time of the last step */
  bool stepped;   /* there was one */
  bool flying;    /* the rotors have carried the vehicle since thrust was commanded */
  uint8_t job;    /* of the next step */
  uint8_t source; /* its strength was renewed last */
  uint32_t unheard; /* broadcasts that were not stored, for Q2Q_NEIGHBOURS others; not counted
                       while the own position is unknown; wraps */
};

/* What one step of the controller knows. */
struct q2q_input {
  uint32_t now_us;
  struct q2q_motion own;
  float force_up; /* specific force along world z: accelerometer, 9.81 at rest [m/s^2] */
  float thrust;   /* commanded collective thrust over the mass [m/s^2] */
  bool flying;    /* as the supervisor says, which it does for 2 s after the motors stopped, too */
};

/* sizeof(struct q2q_app), Q2Q_NEIGHBOURS, and thrust per PWM over the mass [m/s^2], for callers of a shared library. */
extern const uint32_t q2q_app_bytes, q2q_neighbours;
extern const float q2q_acc_per_pwm;

/* Forget everything. */
void q2q_reset(struct q2q_app *app);

/* Return eta^ along z [m/s^2]: subtract it from the setpoint's acceleration. Call at the controller's rate.
   It is 0 where the own motion is not finite; where another input is not, nothing is measured. */
float q2q_step(struct q2q_app *app, const struct q2q_input *input);

/* Store the motion of neighbour `id` at a time; return false if it is refused: not later than the last one, not
   finite, or all places are taken by others received from within Q2Q_STALE_S. One that is clearly nearer takes the
   place of the farthest, by (dx^2 + dy^2) / (2 width^2) + dz^2 / reach_vertical^2 with the jet's width at this dz,
   plus 1 for one that is level or below. */
bool q2q_hear(struct q2q_app *app, uint8_t id, uint32_t stamp_us, const struct q2q_motion *motion);

/* Return the predicted downwash along z [m/s^2] `lead_s` after now_us; own is the motion at now_us. */
float q2q_downwash(struct q2q_app *app, const struct q2q_motion *own, uint32_t now_us, float lead_s);

/* Renew the strength of source j (1 to Q2Q_NEIGHBOURS), of the pairs of the last prediction. */
void q2q_renew_strength(struct q2q_app *app, const struct q2q_motion *own, uint32_t now_us, int j);

/* Take a measured push [m/s^2] where eta was predicted, dt [s] after the last one. */
void q2q_measure(struct q2q_correction *correction, float push, float eta, float dt);

/* Return the part of the residual that is left after `age_s` [m/s^2]. */
float q2q_residual(const struct q2q_correction *correction, float age_s);

/* Write the broadcast of one vehicle, little endian: id, then position [mm], velocity [mm/s], body z x and y [1e-4];
   return false, and write nothing, if the motion is not finite or beyond 32.767 m or m/s. */
bool q2q_pack(uint8_t id, const struct q2q_motion *motion, uint8_t packet[Q2Q_PACKET_BYTES]);

/* Write the motion in a broadcast; return its id. */
uint8_t q2q_unpack(const uint8_t packet[Q2Q_PACKET_BYTES], struct q2q_motion *motion);

#endif
