//! The table of all codes, from which names, documentation, panel texts and the sentences of reports are
//! generated.
//!
//! A row contains number, stable name, kind of the subject and unit of the value; then the panel text, at
//! most three lines of 21 characters; then the sentence with its placeholders: `{subject}`, `{value}` with
//! its unit, and for a response `{hit}` and `{response}`.

codes! {
    // Codes of the layout.

    /// Fewer than three triaxial sensors. Value: how many.
    FewerThanThreeSensors = 1, "fewer_than_three_sensors", Whole, Count;
        "Under 3 sensors: add\nsome. From mass lines\nML answers without.";
        "fewer than three triaxial sensors cannot resolve the six motions of the body, which the inertia \
         restraint method needs and those of the suspension modes; put three on nodes that are not on one line (from \
         mass lines maximum likelihood answers without, with wider intervals)";
    /// The second singular value of the centred sensor positions is below 2 % of the first. Value: the ratio.
    SensorsCollinear = 2, "sensors_collinear", Whole, Share(1);
        "Sensors on one line:\nmove one away.";
        "the sensors stand on one line (within 2 %), so the rotation about that line is not seen, which \
         the inertia restraint method needs and those of the suspension modes; move one sensor away from the \
         line (from mass lines maximum likelihood answers without, with wider intervals)";
    /// `G diag(1,1,1,1/L,1/L,1/L)` has a rank below six (relative cut 1e-6). Value: the rank.
    ResponseRankDeficient = 3, "response_rank_deficient", Whole, Count;
        "Sensors do not see\nall six motions:\nspread or turn them.";
        "the sensors do not resolve all six motions of the body, which the inertia restraint method needs and those \
         of the suspension modes; check their positions and axes, or spread them";
    /// Fewer than three hit degrees of freedom. Value: how many.
    FewerThanThreeHits = 4, "fewer_than_three_hits", Whole, Count;
        "Under 3 hit places:\nadd hits elsewhere,\nother directions.";
        "fewer than three hit DOFs leave some of the ten properties undetermined; add hits at other points \
         in other directions";
    /// The second singular value of the stacked directions is below 2 % of the first. Value: the ratio.
    HitsAllParallel = 5, "hits_all_parallel", Whole, Share(1);
        "All hits parallel:\nadd one in another\ndirection.";
        "all hits are parallel, so some of the ten properties do not show; add a hit in another direction";
    /// All lines of action pass through one point within 2 % of L. Value: the largest distance over L.
    HitsConcurrent = 6, "hits_concurrent", Whole, Share(1);
        "All hits meet in one\npoint: move one past\nit.";
        "the lines of all hits meet in one point (within {value} of L), so one combination of the inertias \
         does not show; move one hit so that its line passes by that point";
    /// All lines of action pass through the centre of mass within 2 % of L. Value: the largest distance over
    /// L.
    HitsThroughCentreOfMass = 7, "hits_through_centre_of_mass", Whole, Share(1);
        "All hits go through\nthe centre of mass:\nhit further out.";
        "the lines of all hits pass the centre of mass (within {value} of L), so they barely rotate \
         the body and its inertia cannot be determined; hit further out";
    /// The balanced regression matrix, or the derivative of the readings with respect to the ten properties,
    /// has a rank below ten (relative cut 1e-6). Value: the rank.
    TenParametersNotIdentifiable = 8, "ten_parameters_not_identifiable", Whole, Count;
        "Cannot find all ten:\nmore hit places or\nsensors needed.";
        "these hits and sensors do not determine all ten properties; hit at other points and in other \
         directions, and use two sensors at least";
    /// Two sensors are on the same node. Subject: the second. Value: the number of the node.
    TwoSensorsOnOneNode = 9, "two_sensors_on_one_node", Sensor, Node;
        "Two sensors on one\nnode: give each its\nown.";
        "{subject} shares its place with another; give it a node of its own";
    /// A sensor or hit names a node that the layout does not have.
    UnknownNode = 10, "unknown_node", SensorOrHit, None;
        "The layout lacks this\nnode: correct the\nlayout.";
        "{subject} names a node that the layout does not have; add the node or name another";
    /// Local axes are not of unit length or not orthogonal. Subject: the sensor, or the hit whose direction
    /// is not of unit length. Value: the deviation.
    AxesNotOrthonormal = 11, "axes_not_orthonormal", SensorOrHit, Share(2);
        "Axes not at right\nangles: correct the\nlayout.";
        "local axes are off unit length or right angles by {value}; give orthogonal unit vectors";
    /// A number of the layout is NaN or infinite, or a standard deviation or mass is negative.
    LayoutNotFinite = 12, "layout_not_finite", Whole, None;
        "A number of the\nlayout is not usable:\ncorrect the layout.";
        "a number of the layout is NaN or infinite; write decimal numbers in SI units";
    /// A setting of the `[test]` table lies outside the range of the rig. Subject: the setting. Value: that
    /// of the setting.
    SettingOutOfRange = 13, "setting_out_of_range", Setting, OfSetting;
        "A setting is out of\nthe rig's range:\nchange [test].";
        "test.{subject} = {value} is out of the rig's range; change it in [test]";
    /// There are data for a hit that the layout does not have. Subject: the hit.
    HitNotInLayout = 14, "hit_not_in_layout", Hit, None;
        "The layout lacks this\nhit: correct the\nlayout.";
        "there are data of {subject}, which the layout does not have; add it to the hits of the layout, or \
         leave its data out";

    // Codes of the data and the answer.

    /// A frequency response or mass line is NaN or infinite. Subject: the hit DOF.
    DataNotFinite = 32, "data_not_finite", Hit, None;
        "A response is no\nnumber: measure it\nagain.";
        "a frequency response is NaN or infinite; measure it again or export it again";
    /// A degree of freedom has no frequency response. Subject: the DOF.
    FrfMissing = 33, "frf_missing", Hit, None;
        "This hit place was\nnot measured.";
        "{subject} has no frequency response; measure it or take it out of the layout";
    /// The band contains too few bins for the fit. Subject: the DOF. Value: the number of bins.
    BandTooNarrow = 34, "band_too_narrow", Hit, Count;
        "Band too narrow:\nwiden test.band_hz.";
        "number of bins of the spectrum in the band: {value}, too few for the mass line; widen test.band_hz or take \
         more bins";
    /// Fewer than three accepted hits, so there is neither scatter nor a standard deviation.
    TooFewHitsForSigma = 35, "too_few_hits_for_sigma", Whole, None;
        "Under 3 hits: no +-\ncan be given. Hit\nmore often.";
        "the scatter of at least three hits is not known for every DOF, so no standard deviation is given; \
         hit at least three times";
    /// The standard deviations cover the scatter between hits only.
    SigmaCoversScatterOnly = 36, "sigma_covers_scatter_only", Whole, None;
        "+- covers the scatter\nof hits only, not\nplaces and gains.";
        "the standard deviations cover the scatter between hits only, not errors that stay the same during \
         a test (placement, rotation, gain)";
    /// The estimate is not a physical body: the mass is not positive or a triangle inequality is violated.
    /// Value: the margin, kg m².
    NotPhysicallyConsistent = 37, "not_physically_consistent", Whole, KilogramSquareMeters;
        "Not a physical body:\ncheck places, signs;\nhit more.";
        "no body has these ten properties: the mass or a principal moment is negative, or one moment \
         exceeds the sum of the others; check positions, directions and signs, and hit more often";
    /// The regression matrix is nearly rank deficient. Value: its condition.
    IllConditioned = 38, "ill_conditioned", Whole, Condition;
        "Nearly unsolvable:\nspread sensors and\nhits.";
        "the equations are nearly singular (condition {value}): small errors become large; spread sensors \
         and hits";
    /// The operator skipped a degree of freedom. Subject: the DOF. Value: its accepted hits.
    DofSkipped = 39, "dof_skipped", Hit, Count;
        "This hit place was\nleft out.";
        "{subject} was left out";
    /// A degree of freedom has fewer hits than configured. Subject: the DOF. Value: its accepted hits.
    DofFinishedEarly = 40, "dof_finished_early", Hit, Count;
        "This hit place has\nfewer hits than\nwanted.";
        "{subject} has {value} accepted hits, fewer than wanted";
    /// No gravity vector is given, so its effect on the sensors is left to the B/s² term.
    GravityNotGiven = 41, "gravity_not_given", Whole, None;
        "Layout gives no\ngravity: less exact\nbelow 20 Hz.";
        "the layout gives no `gravity`, and accelerometers that measure down to 0 Hz feel it as the object tilts: a \
         mass line leaves that to its B/s² term, the suspension profile needs the direction; state the vector, or that \
         the sensors do not sense it";
    /// The flash did not store the result. Make room or try again, then resume.
    ResultNotStored = 42, "result_not_stored", Whole, None;
        "Result not stored:\ndelete an old one,\nthen resume.";
        "the rig could not store the result in its flash; delete old results (massline results delete) and \
         resume";
    /// The converter of the rig does not respond.
    SamplerStopped = 43, "sampler_stopped", Whole, None;
        "No answer from the\nconverter: switch off\nand on again.";
        "the converter of the rig does not answer; switch the rig off and on again";
    /// The residuals are larger than the stated uncertainties allow; chance alone does this in one test of a
    /// thousand. Value: χ² over its degrees of freedom.
    DataInconsistentWithBudget = 44, "data_inconsistent_with_budget", Whole, Times;
        "Data contradict the\nerrors stated: look\nfor a wrong axis.";
        "the data contradict the stated uncertainties (χ² is {value} times what it should be): something \
         is wrong by more than [uncertainty] says; look for a wrong node, axis or sign";
    /// The sensor with the largest pull: the errors that would explain the data exceed its stated
    /// uncertainties most. Subject: the sensor. Value: their root mean square in units of the uncertainties.
    LargeSensorPull = 45, "large_sensor_pull", Sensor, Times;
        "Suspect: check its\nnode, axes and cable.";
        "{subject} would have to be off by {value} times its stated uncertainties; check its node, axes \
         and cable";
    /// The hit with the largest pull: the errors that would explain the data exceed its stated uncertainties most.
    /// Subject: the hit DOF. Value: their root mean square in units of the uncertainties, or of the force alone what is
    /// as rare.
    LargeHitPull = 46, "large_hit_pull", Hit, Times;
        "Suspect: check node,\ndirection and sign.";
        "{subject} would have to be off by {value} times its stated uncertainties; check its node, \
         direction and sign, and the hammer's gain and range then";
    /// The best fit was not a physical body, so the best physically consistent one is given. Value: the
    /// margin of the best fit, kg m².
    HeldToConsistency = 47, "held_to_consistency", Whole, KilogramSquareMeters;
        "Best fit: not a body.\nNearest body shown,\n+- is rough.";
        "this is the best physical body, on the boundary of what a body can be, as the best fit was none; its \
         standard deviations are rough";
    /// The fit did not converge. Value: the number of steps; zero when the computation left the range of
    /// numbers.
    NotConverged = 48, "not_converged", Whole, Count;
        "No fit: check nodes,\naxes and signs of all\nsensors and hits.";
        "the fit did not converge, so there is no estimate: the data contradict the layout, its uncertainties \
         or its [prior]; check nodes, axes and signs of sensors and hits";
    /// The object would have no mass without the attached bodies. Value: the remaining mass, kg.
    AttachedTooHeavy = 49, "attached_too_heavy", Whole, SignedKilograms;
        "Attached masses weigh\nmore than was found:\ncheck them.";
        "what hangs on the object weighs more than was measured ({value} would be left); check the \
         attached masses of the sensors and [[attached]]";
    /// The identified mass is not positive. Value: the mass, kg.
    MassNotPositive = 50, "mass_not_positive", Whole, Kilograms;
        "Mass not positive:\ncheck signs and axes.";
        "the identified mass is {value}, so the data belong to no body; check signs and axes of sensors \
         and hits, and what the responses are";
    /// The object was a block of known mass: the result serves calibration and has no ten properties.
    BlockTest = 52, "block_test", Whole, None;
        "A block of known mass\nwas hit: it only\ncalibrates.";
        "a block of known mass was hit: this calibrates, and has no ten properties; see `massline \
         calibrate`";
    /// The mass line of a response changes with the ends of the band, or scatters. Subject: the response due to a hit
    /// DOF. Value: the change or the standard deviation as a part of the motion of the DOF, the larger one.
    NoPlateau = 53, "no_plateau", Response, Share(1);
        "Its mass line is not\nflat: narrow the band\nor hang softer.";
        "the mass line of {response} due to {hit} changes with the ends of the band, or scatters, by {value} of the \
         motion: keep test.band_hz farther from suspension and elastic modes, or set it to \"auto\"; if only weak \
         responses scatter, hit harder";
    /// The data show no band between suspension and elastic modes, so the default band is used. Subject: the
    /// DOF.
    BandNotFound = 54, "band_not_found", Hit, None;
        "No clear band: 10 to\n120 Hz used. Hang the\nobject softer.";
        "the data of {subject} show no band between suspension and elastic modes; 10 to 120 Hz is used: \
         hang the object softer, or set test.band_hz";
    /// A prior on the object contradicts the data. Subject: the property, in the order of `theta`. Value: the
    /// property from the data without the prior, SI.
    PriorInconsistentWithData = 55, "prior_inconsistent_with_data", Property, OfProperty;
        "[prior] contradicts\nthe data (see value):\ncheck or widen it.";
        "{subject} contradicts the data, which say {value} without it: correct it, or widen its sigma; if \
         it is right, all accelerances or a mark are wrong";
    /// The repeat hits scatter so much in direction that terms of higher order, which the fit leaves out, count.
    /// Value: the standard deviation of the direction about each axis across it, mrad.
    HitsScatterMuch = 56, "hits_scatter_much", Whole, Milliradians;
        "Your hits turn too\nmuch: hold the hammer\nsquare, hit gently.";
        "the hits scatter by {value} in direction, more than the fit can follow (80 mrad): hold the hammer \
         square to the surface, hit more gently, and measure again";
    /// There are too few repeat hits to learn their scatter, so the stated one is used.
    ScatterNotLearned = 57, "scatter_not_learned", Whole, None;
        "Few repeat hits:\ntheir scatter is as\nstated.";
        "the scatter of the hits is taken as [uncertainty] states it, because the repeat hits do not show it: \
         it takes three hits at each DOF, and a stated scatter above zero";
    /// The residuals have too few degrees of freedom to learn the errors of the sensors, so the stated ones are
    /// used. Value: the degrees of freedom.
    ScaleNotLearned = 58, "scale_not_learned", Whole, Count;
        "Few hit places: the\nsensors' errors are\nas stated.";
        "the errors of sensors and marks are taken as [uncertainty] states them, because only {value} readings \
         more than unknowns are left to show them (8 are needed); hit more DOFs";
    /// The mains hum of 50 Hz, or of its harmonics alone, in a channel, which is taken out of every hit. Subject: the
    /// loudest response, or the hammer. Value: the largest amplitude of a harmonic, N or m/s².
    HumOf50Hz = 59, "hum_of_50_hz", Channel, OfChannel;
        "Hum of 50 Hz, taken\nout: check shield and\nground.";
        "{subject} picks up {value} of mains hum at 50 Hz or its harmonics; it is taken out of every hit, but \
         check shielding and ground, or run the rig from a battery";
    /// The mains hum of 60 Hz, or of its harmonics alone, in a channel, which is taken out of every hit. Subject: the
    /// loudest response, or the hammer. Value: the largest amplitude of a harmonic, N or m/s².
    HumOf60Hz = 60, "hum_of_60_hz", Channel, OfChannel;
        "Hum of 60 Hz, taken\nout: check shield and\nground.";
        "{subject} picks up {value} of mains hum at 60 Hz or its harmonics; it is taken out of every hit, but \
         check shielding and ground, or run the rig from a battery";
    /// The hum of the mains in a channel changes during a hit, so it cannot be taken out. Subject: the channel. Value:
    /// what would be left of it at the contact, N or m/s².
    HumUnsteady = 85, "hum_unsteady", Channel, OfChannel;
        "Hum changes: remove\nits source or use a\nbattery; hit again.";
        "{subject} picks up hum at a frequency of the mains that changes during the hit, so that {value} of it would \
         be left; switch off what hums, check shielding and ground, or run the rig from a battery, and hit again";
    /// Suspension or cables are so stiff that the band begins below three times the frequency of a suspension mode
    /// with the same effect. Value: that frequency, Hz.
    SuspensionInBand = 61, "suspension_in_band", Whole, Hertz;
        "Hangs too stiffly for\nthe band: softer\ncords, loose cables.";
        "the object moves as on a suspension of {value}, and the band begins below three times that, which can make \
         mass and inertia wrong; raise the lower end of test.band_hz above three times that or set it to \"auto\", hang \
         the object on softer cords, or let cables hang loose";
    /// Modes near the ends of the band move a property. Subject: the property. Value: its change when the ends of the
    /// band are left out, SI.
    MovesWithBand = 84, "moves_with_band", Property, OfProperty;
        "Moves this much with\nthe band: modes are\ntoo near.";
        "without the ends of the band, {subject} would change by about {value}; it may be wrong by as much: keep \
         test.band_hz farther from suspension and elastic modes, hang the object softer, or set it to \"auto\"";
    /// The readings of a channel are not proportional to the force: harder hits have other accelerances than gentle
    /// ones. Subject: the channel. Value: the change of its largest reading, relative.
    ChannelNotLinear = 82, "channel_not_linear", Channel, Share(1);
        "Not proportional to\nthe force: overload,\nor loose? Hit softer.";
        "{subject} is not proportional to the force: its largest readings are off by about {value}; check its \
         supply, wiring and glue, or hit more gently";

    /// A response contains a part of the hammer's signal: its accelerances have the same constant, whatever is hit.
    /// Subject: the channel. Value: the constant, (m/s²)/N.
    HammerInResponse = 83, "hammer_in_response", Channel, Accelerance;
        "Contains the hammer:\nslow multiplexer, or\nwires too close?";
        "{subject} contains {value} of the hammer's signal; keep the hammer's cable away from the sensors', and let a \
         converter that multiplexes its inputs sample longer";

    /// Every channel keeps a part of the voltage of the channel that is converted before it. Value: the part.
    MultiplexerKeepsVoltage = 86, "multiplexer_keeps_voltage", Whole, Share(1);
        "Channels mix: the\nmultiplexer is too\nfast for its inputs.";
        "every channel seems to keep about {value} of the voltage of the channel converted before it, as through a \
         multiplexer that does not settle: let the converter sample longer, or buffer its inputs; where there is no \
         multiplexer, the tip may push sideways or turn";

    /// The campaign was finished when the target was reached. Value: the number of hits that this has saved.
    StoppedAtTarget = 62, "stopped_at_target", Whole, Count;
        "Target reached: other\nplaces were left out.";
        "the campaign was finished at its [target], which has saved {value} hits";
    /// The 95 % interval of a property is wider than the target. Subject: the property that misses the target
    /// most. Value: its half width over the one wanted.
    TargetMissed = 63, "target_missed", Property, Times;
        "Target missed: its\ninterval is wider by\nthis factor.";
        "the [target] is missed: the 95 % interval of {subject} is {value} times as wide as wanted";
    /// As many hits again at a DOF would narrow the interval that misses the target most. Subject: the DOF.
    /// Value: the share by which it would become narrower.
    HitAgain = 80, "hit_again", Hit, Share(0);
        "For the target: hit\nthis place again.";
        "as many hits again at {subject} would narrow that interval most, by about {value}";

    /// The target is missed, and no further hits would narrow its interval by 1 %.
    HitsDoNotHelp = 81, "hits_do_not_help", Whole, None;
        "Repeating hits would\nnot help: calibrate,\nor hit new places.";
        "further hits at these places would hardly narrow that interval: what limits it is the same in all of them, \
         such as the gain of the hammer or the marks; calibrate, hit other places, or give a [prior]";

    // Codes of a hit.

    /// A channel reached the end of its range: ADC rail, sensor range, or a flat top from clipping in an
    /// earlier stage. Subject: the channel. Value: the extreme relative to the rest value, N or m/s².
    Overload = 64, "overload", Channel, OfChannel;
        "Too hard: a channel\nclipped. Hit more\ngently.";
        "{subject} clipped at {value}: it reached the end of its range, or stayed at one level while the force \
         changed; hit more gently";
    /// The peak force is below `test.min_peak_force_n`: too small for a usable response. Value: the peak, N.
    TooWeak = 65, "too_weak", Whole, Newtons;
        "Too weak: hit harder.";
        "the peak force of {value} is too small for a clear response; hit harder";
    /// Scans were lost while the record was taken. Value: their number.
    ScansLost = 66, "scans_lost", Whole, Count;
        "Samples were lost:\nhit again.";
        "scans were lost while the record was taken; hit again";
    /// The next hit may clip: a channel came near the end of its range. Subject: the channel. Value: the
    /// share of the range.
    TooHard = 67, "too_hard", Channel, Share(0);
        "Nearly too hard: hit\nmore gently.";
        "{subject} came to {value} of its range, so the next hit may clip; hit more gently";
    /// The hammer touched twice. Value: the lesser peak over the greater.
    DoubleHit = 68, "double_hit", Whole, Share(0);
        "Hammer bounced: hold\nit loosely, hit once.";
        "the hammer touched twice (a second peak of {value} of the first); hold it loosely and hit again";
    /// The force hardly excites the top of the band. Value: its level there relative to 0 Hz, dB.
    ForceSpectrumLow = 69, "force_spectrum_low", Whole, Decibels;
        "Hit too soft at high\nfrequencies: take a\nharder tip.";
        "the force hardly excites the top of the band ({value} against 0 Hz); take a harder tip or lower \
         test.band_hz";
    /// A channel moved before the hit. Subject: the channel. Value: the standard deviation before the hit
    /// over the peak.
    PreTriggerNotQuiet = 70, "pre_trigger_not_quiet", Channel, Share(1);
        "It was moving: wait\nuntil it hangs still.";
        "{subject} moved before the hit ({value} of the peak); wait until the object hangs still";
    /// The record ends before force or response have decayed. Subject: the channel. Value: the level at the
    /// end over the peak.
    ClippedRecord = 71, "clipped_record", Channel, Share(0);
        "It rang too long:\ntake the hammer away,\nhold nothing.";
        "the record ends before {subject} is over ({value} of the peak are left); take the hammer away \
         after the hit, or record for longer";
    /// There are too few scans before the hit to determine the rest value. Value: their number.
    TriggerTooEarly = 72, "trigger_too_early", Whole, Count;
        "Hit too early: wait\na moment after the\nsignal.";
        "only {value} scans lie before the hit, too few to know what rest is; record with a longer \
         pre-trigger";
    /// The record is the same as that of the hit before.
    DuplicateHit = 73, "duplicate_hit", Whole, None;
        "Same record as the\nhit before: hit\nagain.";
        "this is the record of the hit before once more; hit again";
    /// A hit differs from its repeat hits. Subject: the DOF. Value: the relative distance of its responses
    /// per force from theirs.
    HitInconsistent = 74, "hit_inconsistent", Hit, Share(0);
        "Unlike the others:\nsame point, same\ndirection each time.";
        "at {subject} one hit differs from the others by {value}; hit the same point in the same direction \
         every time";
    /// The readings of a sensor do not fit the motion of a rigid body. Subject: the sensor. Value: its part
    /// of the residual over the norm of all readings.
    MotionNotRigid = 75, "motion_not_rigid", Sensor, Share(0);
        "Moves unlike a rigid\nbody: check its axes,\ncable, glue.";
        "{subject} does not move with the others as a rigid body ({value} of the readings are left over); \
         check its axes, cable, gain and glue";
    /// The first two hits at a DOF differ and are dropped: it cannot be determined which is wrong. Subject: the DOF.
    /// Value: the relative distance of their responses per force.
    HitsDisagree = 76, "hits_disagree", Hit, Share(0);
        "First two hits differ\nboth dropped: hit the\nsame point.";
        "at {subject} the first and the second hit differ by {value}, so one of them may have landed elsewhere: both \
         are dropped; hit the same point in the same direction every time";
    /// The operator took back a hit that had been accepted. Subject: the DOF.
    HitUndone = 77, "hit_undone", Hit, None;
        "Undone: hit this\nplace again.";
        "the hit at {subject} was undone by the operator and does not count; hit again";

    /// A hit differs so much from several repeat hits that it may have landed elsewhere, or the first two differ so
    /// much from each other. Subject: the DOF. Value: the relative distance of its responses per force from theirs.
    HitElsewhere = 78, "hit_elsewhere", Hit, Share(0);
        "Landed elsewhere?\nHit the marked point\nagain.";
        "a hit at {subject} differs from the others by {value}: it may have landed elsewhere; hit the marked point in \
         the same direction";
    /// The first two hits at a DOF differ; the next one shows whether both have to be dropped. Subject: the DOF. Value:
    /// the relative distance of their responses per force.
    HitsInDoubt = 79, "hits_in_doubt", Hit, Share(0);
        "First two hits differ\none is wrong: hit the\nsame point.";
        "at {subject} the first and the second hit differ by {value}, so one of them may have landed elsewhere; hit \
         the marked point again";

    // Codes of the suspension modes.

    /// Too few suspension modes show in the responses for a method that needs five. Value: how many.
    SuspensionModesMissing = 96, "suspension_modes_missing", Whole, Count;
        "Too few suspension\nmodes: lower the band\nor hit elsewhere.";
        "the responses show {value} suspension modes, and five are needed; measure from below the lowest to \
         above the highest of them, with hits that move the body in all directions";
    /// Four mode shapes give ten equations of rank nine for any body. Value: the rank.
    FourModesRankNine = 97, "toivola_nuutila_four_modes_rank_nine", Whole, Count;
        "Four modes have rank\nnine: five are\nneeded.";
        "four modes give ten equations, but for any body only nine of them are independent (rank {value}); \
         find a fifth mode, or state the mass and a coordinate of the centre of mass in [prior]";
    /// A method needs all six suspension modes. Value: how many there are.
    SixModesNeeded = 98, "six_modes_needed", Whole, Count;
        "It needs six modes:\nhit where the missing\none moves.";
        "this method needs all six suspension modes, and {value} show; hit where the missing mode moves, or widen \
         the suspension band";
    /// The responses below the modes move the body in fewer than six directions. Value: the rank.
    ResponsesDoNotSpanSix = 99, "responses_do_not_span_six", Whole, Count;
        "Responses span fewer\nthan six motions: add\nhits.";
        "the responses at the chosen lines span {value} of the six motions of a body, so the stiffness cannot \
         be eliminated; hit in more directions, so that every mode is excited";
    /// A mode is so near to the end of the lines that only one side of it shows. Subject: the mode. Value:
    /// its frequency.
    ModeAtBandEdge = 100, "mode_at_band_edge", Mode, Hertz;
        "At the end of the\nband: widen it.";
        "{subject} at {value} lies at the end of the suspension band; widen the band to show both sides of it";
    /// The shape of a mode is complex: its damping is not proportional. Subject: the mode. Value: the
    /// imaginary over the real part of its residues.
    ModeComplex = 101, "mode_complex", Mode, Share(1);
        "Its shape is complex:\nmodal methods are\noff by about this.";
        "{subject} has a complex shape (imaginary part {value}), which a damper at one place or a record that \
         is too short causes; modal methods are off by about the square of it, the global fit and the viscous \
         direct method are not";
    /// Two modes are nearer to each other than their half-power bandwidths. Subject: the lower one. Value:
    /// their distance over the mean bandwidth.
    ModesClose = 102, "modes_close", Mode, Factor;
        "Two modes nearly\ncoincide: shapes are\nuncertain.";
        "{subject} and the next higher one are {value} bandwidths apart, so their shapes mix; more hits tell them \
         apart, or another suspension separates them";
    /// A mode hardly shows under any force. Subject: the mode. Value: its largest Norm Indicator over the
    /// median of the modes.
    ModePoorlyExcited = 103, "mode_poorly_excited", Mode, Share(0);
        "Hardly excited by any\nhit: hit where it\nmoves.";
        "{subject} is hardly excited by any hit ({value} of the median Norm Indicator); hit where and along \
         which it moves";
    /// The structural form of the direct method fits better. Value: the misfit of the viscous form over it.
    DampingNotViscous = 104, "damping_not_viscous", Whole, Times;
        "Structural damping\nfits better.";
        "structural damping fits these responses {value} times better than viscous damping; rely on the \
         structural form";
    /// The viscous form of the direct method fits better. Value: the misfit of the structural form over it.
    DampingNotStructural = 105, "damping_not_structural", Whole, Times;
        "Viscous damping fits\nbetter.";
        "viscous damping fits these responses {value} times better than structural damping; rely on the viscous \
         form";
    /// A flexible mode above the band moves the apparent mass within it. Value: the largest distance of the answer from
    /// that of the global fit, relative to scale.
    FlexibleModeAboveBand = 106, "flexible_mode_above_band", Whole, Share(1);
        "A part on springs\nmoves the mass: only\nthe global fit holds.";
        "a flexible mode above the band moves the apparent mass, which only the global fit takes into account; \
         this answer is {value} of scale away from it";
    /// The decay of a mode does not fit into a record. Subject: the mode. Value: what is left of it at the end.
    RecordTooShort = 107, "record_too_short_for_damping", Mode, Share(1);
        "Still swings at the\nend of the record:\nrecord longer.";
        "{subject} still has {value} of its amplitude at the end of a record, which makes its shape complex; \
         record longer, or use an exponential window and state its --decay";

    /// Lines are missing within the suspension band. Value: where the gap begins.
    FrequencyGap = 108, "frequency_gap", Whole, Hertz;
        "Lines are missing: a\nmode may hide in the\ngap.";
        "lines of the suspension band are missing from {value} on; a mode may hide in the gap, so export all \
         lines";

    /// The point that is hit moves against the force. Subject: the hit.
    DrivingPointReversed = 109, "driving_point_reversed", Hit, None;
        "Moves against its\nforce: check sign and\ndirection.";
        "the point of {subject} moves against the force, which no body does; check the sign of the hit, the \
         axes of the sensors and the polarity of the hammer";
    /// Every point that is hit moves against the force.
    AllPointsReversed = 125, "all_points_reversed", Whole, None;
        "All points move\nagainst the hammer:\nreversed polarity?";
        "every point that is hit moves against the force, which no body does: the hammer has reversed polarity, or the \
         responses are displacements and not accelerations, which have the opposite sign (--quantity receptance)";
    /// The responses are in phase with the forces near the suspension modes, or a quarter of a period from them above,
    /// as velocities are.
    LooksLikeMobility = 130, "looks_like_mobility", Whole, None;
        "Responses look like\nvelocities, not\naccelerations.";
        "the responses move as velocities do and accelerations do not: in phase with the force at the resonances, and \
         a quarter of a period from it above them; say so (--quantity mobility)";
    /// The response at one hit to the other is not that at the other to the one. Subject: both. Value: the
    /// difference relative to their driving points.
    NotReciprocal = 110, "not_reciprocal", HitPair, Share(0);
        "Not reciprocal: check\ntheir points and\ndirections.";
        "{subject} are not reciprocal: what each does at the other differs by {value}; check their points and \
         directions, and those of the sensors";
    /// The data say next to nothing about a property. Subject: the property. Value: its standard deviation relative to
    /// its scale.
    PropertyUndetermined = 111, "property_undetermined", Property, Share(0);
        "These data do not\ndetermine it: hit in\nmore directions.";
        "{subject} is not determined: its standard deviation is {value} of its scale; hit in more directions and \
         places, so that every mode is excited";
    /// A method has no answer to data that differ by the noise. Value: the share of such data.
    UnstableUnderNoise = 119, "unstable_under_noise", Whole, Share(0);
        "Noise decides whether\nit answers: hit\nharder.";
        "this method has no answer to {value} of data that differ from these by the noise alone; hit harder or \
         more often, so that every mode stands out";
    /// Two modes at nearly the same frequency were found as one, so that their shapes are not known. Subject: the mode.
    /// Value: its frequency.
    ModesNotSeparated = 120, "modes_not_separated", Mode, Hertz;
        "Two modes in one:\nhang the object less\nevenly.";
        "{subject} at {value} is two modes that cannot be told apart, so their shapes are not known; rely on the \
         methods without modes, or hang the object so that their frequencies differ";
    /// The readings of the sensors fit no motion of a rigid body. Value: the part that does not fit.
    ReadingsNotRigid = 121, "readings_not_rigid", Whole, Share(0);
        "Sensors contradict\neach other: check\naxes and gains.";
        "{value} of the readings fit no motion of a rigid body; check axes, gains, positions and cables of the \
         sensors";

    /// A body on a suspension does not explain the readings as well as their own modes do. Value: what it leaves,
    /// relative to the noise.
    ModelDoesNotFit = 122, "model_does_not_fit", Whole, Times;
        "Does not fit: check\ngravity, gains and\nplaces.";
        "no body on a suspension fits these responses (it leaves {value} times their noise), so the answer may be \
         wrong by more than it says; check gravity and senses_gravity, gains, places and directions; a delay or a \
         high-pass between hammer and sensors, hum, and a loose part do this as well";
    /// The global fit leaves a small part of the readings besides their noise. Value: that part.
    ModelFitsRoughly = 132, "model_fits_roughly", Whole, Share(1);
        "Fits roughly: noise\ngrows with responses,\nor small errors.";
        "the global fit leaves {value} of the responses besides their noise, as noise does that grows with them, and \
         small errors of gains, delays or filters; where it is not noise, the answers may be off by a few times as \
         much, modal-constant most";
    /// A flexible mode above the band shows within it.
    FlexibleModeShows = 133, "flexible_mode_shows", Whole, None;
        "A part on springs\nmoves the mass within\nthe band.";
        "a flexible mode above the band moves the apparent mass within it: only the global fit takes it into account, \
         and there is no mass line below that mode";
    /// The readings are explained without one hit, and not with it. Subject: the hit.
    HitContradictsOthers = 126, "hit_contradicts_others", Hit, None;
        "Contradicts the other\nhits: check it or\nleave it out.";
        "a body on a suspension explains these responses without {subject}, and none does with it: check its point, \
         direction and sign, and the gain of the hammer then; or leave it out (--hits)";
    /// Hum or the like disturbs some lines, which the global fit leaves out. Value: where they begin.
    LinesDisturbed = 127, "lines_disturbed", Whole, Hertz;
        "Hum in some lines:\nthey are left out.";
        "the lines from {value} on are disturbed, as by hum, and no body moves like that: the global fit leaves them \
         out";
    /// Sensors sense gravity that should not by the layout, or the other way round.
    SensesGravitySuspect = 128, "senses_gravity_suspect", Whole, None;
        "Which sensors sense\ngravity? Correct the\nlayout.";
        "the responses contradict senses_gravity of the layout's sensors, and fit when all of them do or none does; \
         correct it (accelerometers that measure down to 0 Hz sense gravity)";
    /// Another direction of gravity explains the readings, and that of the layout does not. Value: the direction.
    GravitySuspect = 123, "gravity_suspect", Whole, SignedAxis;
        "Gravity seems wrong:\ncorrect the layout.";
        "the responses fit with gravity along {value}, which the layout does not state: correct or add `gravity` there";
    /// Gravity with the opposite sign explains the readings, and that of the layout does not.
    GravityReversed = 131, "gravity_reversed", Whole, None;
        "Gravity seems\nreversed: correct\nthe layout.";
        "the responses fit with gravity reversed, and not as the layout states it: change the signs of its vector, \
         which points down";
    /// Gravity with a direction of its own explains the readings, and that of the layout does not. Value: the angle
    /// between them.
    GravityTilted = 129, "gravity_tilted", Whole, Degrees;
        "Gravity is tilted:\nlevel the object or\ncorrect the layout.";
        "gravity lies {value} from its direction in the layout, as the responses show: the answers use the direction \
         that fits; level the object, or correct gravity in the layout";
    /// The responses show a mode more than a rigid body on a suspension has. Value: its frequency.
    MoreModesThanSix = 124, "more_modes_than_six", Whole, Hertz;
        "A seventh mode: the\nobject is not rigid\nhere.";
        "besides six suspension modes there is one more at about {value}: a part of the object, a cord or a stand \
         moves by itself, and no method for rigid bodies holds; fix what is loose, or make the suspension softer";

    // Codes of a campaign on the suspension modes.

    /// The impulse of a hit is below `test.impulse_ns`: too small for a clear response. Value: the impulse, N s.
    ImpulseTooSmall = 134, "impulse_too_small", Whole, NewtonSeconds;
        "Push too weak: hit\nharder, with a softer\nand heavier mallet.";
        "the impulse of {value} is too small for a clear response of the suspension modes; hit harder, with a softer \
         and heavier mallet";
    /// The impulse of a hit is above `test.impulse_ns`: so large that the object swings far. Value: the impulse, N s.
    ImpulseTooLarge = 135, "impulse_too_large", Whole, NewtonSeconds;
        "Push too strong: hit\nmore gently.";
        "the impulse of {value} makes the object swing far, where springs and cords are not linear; hit more gently";
    /// The lines of a DOF could not be stored.
    LinesNotStored = 136, "lines_not_stored", Hit, None;
        "DOF not stored.\nResume tries again.";
        "the rig could not store the lines of {subject}; resume to try again";

    // Codes of the self-test.

    /// All outputs of a sensor are at 0 V. Subject: the sensor. Value: the highest of them.
    SensorSilent = 140, "sensor_silent", Sensor, Volts;
        "Sensor is silent:\nplug it in, check its\n3V3 and ground.";
        "{subject} gives no signal ({value} on all axes): its cable is not plugged in, or its supply wire is broken";
    /// All outputs of a sensor are far below what any acceleration gives, but not at 0 V. Value: the highest of them.
    SensorReversed = 141, "sensor_reversed", Sensor, Volts;
        "Supply swapped?\nSwitch off; check 3V3\nand ground.";
        "all outputs of {subject} are at most {value}, which no acceleration gives: 3V3 and ground are probably \
         swapped; switch the rig off and check its connector";
    /// A sensor gets its supply through the output of x. Value: the level of x.
    CableReversed = 165, "cable_reversed", Sensor, Volts;
        "Cable the wrong way\nround: turn its plug.";
        "{subject} has {value} at x, and y and z have half of that: its cable is the wrong way round, so that the \
         supply reaches it through x; turn the plug";
    /// All outputs of a sensor are at the supply. Value: the lowest of them.
    SensorGroundOpen = 142, "sensor_ground_open", Sensor, Volts;
        "Sensor at supply:\nits ground wire is\nbroken.";
        "all outputs of {subject} are at the supply ({value}): its ground wire is broken";
    /// One output of a sensor is at 0 V. Subject: the channel. Value: the level.
    AxisSilent = 143, "axis_silent", Channel, Volts;
        "One axis is silent:\nits wire is broken.";
        "{subject} is at {value} although its sensor works: the wire of this axis is broken, or shorted to ground";
    /// One output of a sensor is at the supply. Value: the level.
    AxisAtSupply = 144, "axis_at_supply", Channel, Volts;
        "One axis is at the\nsupply: look for a\nsolder bridge.";
        "{subject} is at the supply ({value}): look for a solder bridge between it and 3V3";
    /// The output is none that the sensor can have at rest. Value: the level.
    RestLevelOutOfRange = 145, "rest_level_out_of_range", Channel, Volts;
        "Not a rest level:\ncheck wire, follower,\nsensor type.";
        "{subject} rests at {value}, and an ADXL326 that is not moved rests at 1.14 to 1.86 V: check wire, follower \
         and type of the sensor";
    /// The code of a sensor's channel does not change.
    ChannelStuck = 146, "channel_stuck", Channel, None;
        "This channel does not\nchange: check sensor\nand follower.";
        "{subject} does not even have noise, so it is not the sensor that is read: check its follower and the wire to \
         the rig";
    /// A channel has far more noise than its sensor. Value: the standard deviation.
    ChannelNoisy = 147, "channel_noisy", Channel, Volts;
        "Too much noise: loose\ncontact or missing\ncapacitor.";
        "{subject} has noise of {value}, far more than its sensor: look for a loose contact, a missing capacitor, or a \
         follower that oscillates";
    /// Two channels read the same at every instant. Subject: the second of them.
    ChannelsAlike = 148, "channels_alike", Channel, None;
        "Reads the same as\nanother: look for a\nsolder bridge.";
        "{subject} reads the same as a channel before it at every instant: look for a solder bridge between them";
    /// A sensor moved during the self-test. Value: by how much its acceleration changed.
    NotAtRest = 149, "not_at_rest", Sensor, OfChannel;
        "It moves: let it come\nto rest, and test\nagain.";
        "{subject} was moved during the test (by {value}): let the object come to rest, or lay the sensors down, and \
         test again";
    /// Mains of 50 Hz in a channel at rest. Value: the amplitude.
    PickUp50Hz = 150, "pick_up_50_hz", Channel, Volts;
        "50 Hz mains pick-up:\ncheck ground wires,\nor use a battery.";
        "{subject} picks up {value} of 50 Hz from the mains: check the ground wires of its cable, move it away from \
         mains, or run the rig from its battery";
    /// Mains of 60 Hz in a channel at rest. Value: the amplitude.
    PickUp60Hz = 151, "pick_up_60_hz", Channel, Volts;
        "60 Hz mains pick-up:\ncheck ground wires,\nor use a battery.";
        "{subject} picks up {value} of 60 Hz from the mains: check the ground wires of its cable, move it away from \
         mains, or run the rig from its battery";
    /// Mains in all channels at rest. Value: the largest amplitude.
    MainsInAllChannels = 166, "mains_in_all_channels", Whole, Volts;
        "Mains hum in all\nchannels: unplug the\ncharger, use battery.";
        "all channels pick up the mains, up to {value}: unplug charger and wall plugs, and run the rig from its \
         battery or from a computer that runs from its own; check the ground wires of the sensors";
    /// The refresh of the screen shows in all sensors. Value: the largest amplitude.
    ScreenInAllSensors = 167, "screen_in_all_sensors", Whole, Volts;
        "The screen's ripple\nis in all sensors:\ncheck its supply.";
        "all sensors have the screen's ripple at about 105 Hz, up to {value}: check the regulator that supplies the \
         screen, and its ground wire";
    /// Most channels do the same at every instant, because the supply is not steady.
    SupplyUnsteady = 168, "supply_unsteady", Whole, None;
        "Supply not steady:\ncharge, or look for a\nloose power wire.";
        "most channels do the same at every instant, because their supply is not steady: charge the battery, try \
         another cable, and look for a loose contact in the wires of 3V3 and ground";
    /// The refresh of the screen shows in a channel. Value: the amplitude.
    ScreenRipple = 152, "screen_ripple", Channel, Volts;
        "The screen's ripple\nis in this channel:\ncheck its supply.";
        "{subject} has {value} of the screen's ripple at about 105 Hz: check the filter in the supply of the screen, \
         and its ground wire";
    /// Nothing is connected to the hammer's input. Value: the level.
    HammerAbsent = 153, "hammer_absent", Whole, Volts;
        "No hammer: plug it in\nand switch its amp\non.";
        "nothing drives the hammer's input ({value}): plug the hammer in, and switch its conditioner on";
    /// The hammer's input is at 0 V. Value: the level.
    HammerAtGround = 154, "hammer_at_ground", Whole, Volts;
        "Hammer at 0 V: short\nin its cable? On a\nBlack Pill: KEY?";
        "the hammer's input is shorted to ground ({value}): check its cable and socket; on a Black Pill its button KEY \
         does that while it is pressed";
    /// The hammer's input is at its upper end. Value: the level.
    HammerAtSupply = 155, "hammer_at_supply", Whole, Volts;
        "Hammer at the end of\nits range: check its\nconditioner.";
        "the hammer's input is at the end of its range ({value}): check the offset of its conditioner and the wiring \
         of its input";
    /// By its calibration a sensor does not read 1 g at rest. Value: what it reads, in g.
    NotOneGravity = 156, "not_one_gravity", Sensor, Factor;
        "Reads not 1 g: check\nits type; calibrate\nagain (tumble).";
        "{subject} reads {value} g at rest by its calibration: another sensor than the calibrated one, or it is \
         damaged; calibrate it again (massline calibrate tumble)";
    /// A flash chip on a Black Pill loads the inputs. Value: the level of its select pin.
    FlashOnInputs = 157, "flash_on_inputs", Whole, Volts;
        "A flash chip sits on\nPA4 to PA7: unsolder\nit.";
        "PA4 rests at {value}, to which the select pin of a flash chip pulls it: some Black Pills have one on PA4 to \
         PA7 (U3, eight legs, on the back); unsolder it";
    /// The cutoff of a channel, by its calibration, is that of a breakout's own capacitor. Value: the cutoff.
    CapacitorLeft = 158, "capacitor_left", Channel, Hertz;
        "Capacitor left on the\nbreakout: remove it,\nthen block test.";
        "{subject} has a cutoff of {value} by its calibration, far below the rig's own filter: take the breakout's own \
         capacitor off, and calibrate again (massline calibrate block)";
    /// The rig's crystal does not oscillate.
    CrystalDead = 159, "crystal_dead", Whole, None;
        "The crystal does not\nwork: time is a few %\noff.";
        "the crystal of the board does not oscillate, so all frequencies are up to a few per cent off, and USB may \
         fail: look for a broken joint at the crystal";
    /// The supply is too low to write flash.
    SupplyTooLow = 160, "supply_too_low", Whole, None;
        "The supply is too\nlow to store: charge,\nor another cable.";
        "the supply of the rig is too low to write flash: charge its battery, or try another cable or USB port";
    /// The data line of an external converter stays high.
    ConverterLineHigh = 161, "converter_line_high", Whole, None;
        "ADS7953 silent: check\nits supply, CS, SCLK,\nSDO.";
        "nothing drives the data line of the converter (ADS7953): check its supply, and its wires CS, SCLK and SDO";
    /// The data line of an external converter stays low.
    ConverterLineLow = 162, "converter_line_low", Whole, None;
        "ADS7953: SDO stays\nlow. Shorted?";
        "the data line of the converter (ADS7953) stays low: look for a short between SDO and ground";
    /// An external converter sends frames, but of one channel only.
    ConverterWithoutCommands = 163, "converter_without_commands", Whole, None;
        "ADS7953 hears no\ncommands: check SDI.";
        "the converter (ADS7953) sends one channel only, because it does not receive the commands: check its wire SDI";
    /// A frame of an external converter is not of the channel that is due. Value: the channel in its tag.
    ConverterWrongTag = 164, "converter_wrong_tag", Whole, Count;
        "ADS7953 out of step:\ncheck SCLK, SDO and\nground; shorten them.";
        "a frame of the converter (ADS7953) says channel {value} where another one is due: check its wires SCLK and \
         SDO and its ground, and make them shorter";

    // Codes of single mistakes that would explain the data.

    /// One sensor with reversed, swapped or rotated axes explains the data. Subject: the sensor. Value: χ².
    SensorAxesSuspect = 112, "sensor_axes_suspect", Sensor, ChiSquared;
        "Its axes look turned,\nswapped or reversed.";
        "{subject} has its axes reversed, swapped or turned (χ² {value})";
    /// Swapped cables of two sensors explain the data. Value: χ².
    CablesSwapped = 113, "cables_swapped", Whole, ChiSquared;
        "Cables of two sensors\nlook swapped.";
        "the cables of two sensors are swapped (χ² {value})";
    /// One DOF that was hit at another node explains the data. Subject: the DOF. Value: χ².
    HitAtWrongNode = 114, "hit_at_wrong_node", Hit, ChiSquared;
        "It seems to have been\nhit at another node.";
        "{subject} landed on another node (χ² {value})";
    /// One DOF that was hit from the other side explains the data. Subject: the DOF. Value: χ².
    HitReversed = 115, "hit_reversed", Hit, ChiSquared;
        "It seems to have been\nhit from the other\nside.";
        "{subject} came from the other side (χ² {value})";
    /// All accelerances are wrong by one factor, according to the priors on the object. Value: the factor.
    CommonScale = 116, "common_scale", Whole, Factor;
        "All responses off by\none factor: check the\nhammer's gain.";
        "all accelerances are {value} times what they should be; hammer and sensors cannot be told apart";
    /// The data contradict the error budget, and no single mistake explains them. Value: the smallest χ².
    NoSingleFaultExplains = 117, "no_single_fault_explains", Whole, ChiSquared;
        "No single mistake\nexplains these data.";
        "the data contradict the budget and no single mistake explains them (χ² {value})";
    /// Some single mistakes would not be visible in the data. Value: their number.
    FaultsNotVisible = 118, "faults_not_visible", Whole, Count;
        "Some mistakes would\nnot show in these\ndata.";
        "{value} single mistakes would not show in these data";
    /// A wrong gain of one channel, one sensor or one hit explains the data. Value: the readings over their true
    /// values.
    GainSuspect = 87, "gain_suspect", Whole, Factor;
        "Wrong gain?";
        "one gain is wrong: the readings are {value} times what they should be";
    /// Two nodes whose positions are swapped explain the data. Value: χ².
    NodesSwapped = 88, "nodes_swapped", Whole, ChiSquared;
        "Nodes swapped?";
        "the positions of two nodes are swapped (χ² {value})";
    /// One wrong coordinate of a node explains the data. Value: the true minus the written coordinate, m.
    CoordinateSuspect = 89, "coordinate_suspect", Whole, Factor;
        "Wrong coordinate?";
        "one coordinate of a node is wrong by {value} m";
    /// One DOF that was hit beside its node explains the data. Subject: the DOF. Value: χ².
    HitBesideNode = 90, "hit_beside_node", Hit, ChiSquared;
        "Hit beside its node?";
        "{subject} landed beside its node (χ² {value})";
    /// No single mistake explains the data, but errors of the stated kinds that are larger than stated do. Value: the
    /// largest factor.
    ErrorsLargerThanStated = 91, "errors_larger_than_stated", Whole, Factor;
        "Errors above budget.";
        "the errors are up to {value} times those stated";
}
