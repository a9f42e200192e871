% Steady map of one cobotic drive-train as a private script: whole arrays at once, no package.
%
% Run as: octave-cli --quiet --norc steady_map.m parameters.json coarse.bin
% Prints seconds and peak memory (getrusage) as JSON; writes every "stride"-th point of each output to coarse.bin.
1;

function [out, losses] = steady_map(p, v, f)
  % Powers and losses [W], efficiency, limit code and margin; speed (column) along the first axis, force (row) along
  % the second.
  OK = 0; SLIP = 1; THERMAL = 2; VOLTAGE = 3; SPEED = 5;
  slip_force = p.friction * p.preload;
  rolling_force = (p.rolling_torque + p.bearing_torque) / p.wheel_radius;
  surface_speed = p.cylinder_radius * p.cylinder_speed; % > 0
  h = rolling_force / slip_force;
  k = p.creep_stiffness / slip_force;

  % Steering: t = tan(phi) = (e - q)/(1 + e q), q link over surface speed. The creepage e is small and hardly depends
  % on t: each fixed-point step leaves an error about 200 times smaller than itself.
  friction = p.guideway_coefficient * p.preload;
  guideway = friction * (v > 0) - min(f, friction) .* (v == 0);  % at rest it takes what it can of the load
  load = (f + guideway) / slip_force;
  q = v / surface_speed;
  t = -q;
  for step = 1:50
    e = (h * t - load .* sqrt(1 + t .* t)) / k;
    new = (e - q) ./ (1 + e .* q);
    moved = max(max(abs(new - t)));
    t = new;
    if moved < 1e-9
      break
    end
  end

  % Contact forces and speeds; beyond slip there is no steady motion.
  cosine = 1 ./ sqrt(1 + t .* t);
  sine = t .* cosine;
  ratio = h * t - load ./ cosine;
  worst = abs(ratio);
  ratio(worst > 1) = NaN;
  e = ratio / k;
  rolling_speed = surface_speed ./ (cosine + e .* sine);
  lateral = slip_force * ratio;
  torque = p.cylinder_radius * (lateral .* sine + rolling_force * cosine);

  % Gear with constant friction torque, motor, amplifier that burns what comes back.
  motor_speed = p.gear_ratio * p.cylinder_speed;
  gear_friction = (1 - p.gear_efficiency) * p.continuous_torque;
  current = (torque / p.gear_ratio + gear_friction) / p.torque_constant + p.no_load_current;
  voltage = current * p.resistance + p.torque_constant * motor_speed;
  electrical = voltage .* current;
  out.power_in = electrical .* (electrical > 0);
  out.power_out = f .* v;
  % What is the same at all points, or at all points of one speed, stays a scalar or a column.
  losses.winding = current .* current * p.resistance;
  losses.motor_friction = p.torque_constant * p.no_load_current * motor_speed;
  losses.gearhead = gear_friction * motor_speed;
  losses.amplifier = -electrical .* (electrical < 0);
  losses.creep = lateral .* e .* rolling_speed;
  losses.rolling = p.rolling_torque / p.wheel_radius * rolling_speed;
  losses.bearing = p.bearing_torque / p.wheel_radius * rolling_speed;
  losses.guideway = guideway .* v;

  % The limit that binds is the one with the largest demand over allowance.
  continuous_current = p.continuous_torque / p.torque_constant + p.no_load_current;
  limit = repmat(int8(SLIP), size(worst));
  used = abs(current) / continuous_current;
  limit(used > worst) = THERMAL;
  worst = max(worst, used); % ignores NaN
  used = abs(voltage) / p.voltage;
  limit(used > worst) = VOLTAGE;
  worst = max(worst, used);
  used = abs(motor_speed) / p.max_speed;
  limit(used > worst) = SPEED;
  worst = max(worst, used);
  limit(worst <= 1) = OK;
  out.limit = limit;
  out.margin = 1 ./ worst;

  % Useful over spent power; on this grid the load never drives.
  out.efficiency = out.power_out ./ out.power_in;
  out.efficiency(limit != OK | !(out.power_in > 0)) = NaN;
end

arguments = argv();
p = jsondecode(fileread(arguments{end - 1}));
v = linspace(0, p.top_speed, p.points)';
f = linspace(0, p.top_force, p.points);
tic;
[out, losses] = steady_map(p, v, f);
seconds = toc;
maxrss = getrusage().maxrss;

coarse = 1:p.stride:p.points;
file = fopen(arguments{end}, "w");
for part = {out, losses}
  for [value, name] = part{1}
    full = double(value) + zeros(p.points, p.points);
    fwrite(file, full(coarse, coarse)', "double"); % rows of one speed, one after the other
  end
end
fclose(file);
printf("{\"seconds\": %.6f, \"maxrss\": %d}\n", seconds, maxrss);
